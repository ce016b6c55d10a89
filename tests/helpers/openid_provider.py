"""A provider of OpenID Connect, Canaille, with its people in memory: `python openid_provider.py CALLBACK...`.

It prints its issuer when it is ready, and ends with its standard input.
"""

import datetime
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CLIENT, SECRET = "breastrig", "a-secret-of-the-client"
PASSWORD = "correct horse battery staple"
PEOPLE = {  # name: groups
    "anna": ("clinic-north",),
    "bea": ("clinic-south",),
    "rose": ("clinic-north-readers", "clinic-ward"),
    "zoe": ("kitchen",),
}


@contextmanager
def openid_provider(*callbacks: str) -> Iterator[str]:
    """Its issuer; it is a process of its own, and redirects to these addresses alone."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", str(Path(__file__)), *callbacks],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        issuer = process.stdout.readline().strip()
        assert issuer, "the provider did not start"
        yield issuer
    finally:
        process.stdin.close()
        process.wait(30)
        process.stdout.close()


def serve(callbacks: list[str]) -> None:
    from canaille import create_app
    from canaille.app import models
    from canaille.backends import Backend
    from joserfc.jwk import RSAKey
    from werkzeug.serving import make_server

    listener = make_server("127.0.0.1", 0, lambda _environ, _start: [], threaded=True)
    address = f"127.0.0.1:{listener.server_port}"
    app = create_app(
        {
            "SECRET_KEY": "of a test",
            "SERVER_NAME": address,
            "PREFERRED_URL_SCHEME": "http",
            "CANAILLE": {"DATABASE": "memory", "LOGGING": {"version": 1, "disable_existing_loggers": True}},
            "CANAILLE_OIDC": {"ACTIVE_JWKS": [RSAKey.generate_key(2048, auto_kid=True).as_dict(private=True)]},
        }
    )
    now = datetime.datetime.now(datetime.UTC)
    with app.app_context():
        members: dict[str, list[object]] = {}
        for name, groups in PEOPLE.items():
            user = models.User(
                user_name=name, formatted_name=name.title(), family_name=name, emails=[f"{name}@example.com"],
                password=PASSWORD,
            )  # fmt: skip
            Backend.instance.save(user)
            for group in groups:
                members.setdefault(group, []).append(user)
        for group, users in members.items():
            Backend.instance.save(models.Group(display_name=group, members=users))
        client = models.Client(
            client_id=CLIENT,
            client_secret=SECRET,
            client_id_issued_at=now,
            client_name="BreastRig",
            client_uri=f"http://{address}",
            contacts=["nobody@example.com"],
            redirect_uris=callbacks,
            grant_types=["authorization_code"],
            response_types=["code"],
            scope=["openid", "profile", "groups"],
            token_endpoint_auth_method="client_secret_basic",
        )
        Backend.instance.save(client)
        client.audience = [client]
        Backend.instance.save(client)
    listener.app = app
    threading.Thread(target=listener.serve_forever, daemon=True).start()
    sys.stdout.write(f"http://{address}\n")
    sys.stdout.flush()
    sys.stdin.read()


if __name__ == "__main__":
    serve(sys.argv[1:])
