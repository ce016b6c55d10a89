"""nginx with the configuration of docs/how-to/own_server.md, on loopback, in front of a service of the tests' own."""

import os
import re
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import trustme

from helpers.waiting import PATIENCE_S, until

PLACE = "/usr/sbin/nginx"  # where Debian keeps it, which is not on everybody's PATH
NONE_HERE = (
    "These tests need nginx: install the package nginx-light (apt-get install nginx-light, or sh .ci/nginx.sh), or set "
    "BREASTRIG_NGINX to its path."
)
TEMPORARY = ("client_body", "proxy", "fastcgi", "scgi", "uwsgi")  # else nginx wants folders of the system's


def program() -> str:
    """The path of nginx; fails with a sentence when there is none."""
    found = os.environ.get("BREASTRIG_NGINX") or shutil.which("nginx") or PLACE
    assert Path(found).is_file(), NONE_HERE
    return found


def moved(configuration: str, changes: dict[str, str]) -> str:
    """The configuration with other places in it; each must have been there."""
    for place, other in changes.items():
        assert place in configuration, f"the documented configuration has no {place}"
        configuration = configuration.replace(place, other)
    return configuration


@contextmanager
def in_front_of(port: int, readme: str, authority: trustme.CA) -> Iterator[int]:
    """The port of nginx, which speaks TLS and asks the service at `port`, as docs/how-to/own_server.md says."""
    found = re.search(r"```nginx\n(.*?)```", readme, re.DOTALL)
    assert found, "docs/how-to/own_server.md has no configuration for nginx"
    name = re.search(r"server_name (\S+);", found[1])
    assert name
    with tempfile.TemporaryDirectory(prefix="nginx-", dir="/tmp") as place:
        folder, own_port = Path(place), free_port()
        certified(name[1], authority, folder)
        changes = {
            "listen 443 ssl": f"listen 127.0.0.1:{own_port} ssl",
            "/etc/ssl/certs/scans.pem": str(folder / "certificate"),
            "/etc/ssl/private/scans.key": str(folder / "key"),
            "http://127.0.0.1:8321": f"http://127.0.0.1:{port}",
        }
        paths = "".join(f"{name}_temp_path {folder / name};\n" for name in TEMPORARY)
        user = "user root;\n" if os.geteuid() == 0 else ""
        (folder / "nginx.conf").write_text(
            f"{user}daemon off;\npid {folder / 'pid'};\nerror_log stderr;\nevents {{}}\n"
            f"http {{\naccess_log off;\n{paths}{moved(found[1], changes)}}}\n"
        )
        command = [program(), "-p", place, "-c", str(folder / "nginx.conf"), "-e", "stderr"]
        with listening(command, own_port, folder / "log"):
            yield own_port


def certified(name: str, authority: trustme.CA, folder: Path) -> None:
    """Writes `key` and `certificate`."""
    made = authority.issue_cert(name)
    made.private_key_pem.write_to_path(str(folder / "key"))
    made.cert_chain_pems[0].write_to_path(str(folder / "certificate"))


@contextmanager
def listening(command: list[str], port: int, log: Path, **environment: str) -> Iterator[None]:
    """A program that runs and listens at the port."""
    with log.open("w") as stream:
        process = subprocess.Popen(command, stdout=stream, stderr=stream, env={**os.environ, **environment})
    try:

        def ready() -> bool:
            assert process.poll() is None, log.read_text()
            with socket.socket() as probe:
                return probe.connect_ex(("127.0.0.1", port)) == 0

        until(ready, command[0])
        yield
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE_S)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
