"""The service behind real proxies, nginx as documented, Caddy as shipped, with TLS; and whom it does not believe."""

import ssl
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
import trustme
from helpers.caddy import caddy_in_front_of
from helpers.nginx import in_front_of
from helpers.raw_http import answer, connected, request
from helpers.real_server import server
from helpers.waiting import PATIENCE_S, until

from breastrig.api.access import rate_limits

TOKEN = "a-token-of-more-than-sixteen-characters"
NAME = "scans.hospital.example"
BEARER = {"Authorization": f"Bearer {TOKEN}"}


@dataclass(frozen=True)
class Behind:
    port: int  # of the service itself
    proxy_ports: dict[str, int]
    client: Callable[..., httpx.Client]  # one that asks a proxy; `address` is where it asks from
    trust: ssl.SSLContext
    log: Path


@pytest.fixture(scope="module")
def behind(tmp_path_factory: pytest.TempPathFactory, model: Path, repository: Path) -> Iterator[Behind]:
    folder, authority = tmp_path_factory.mktemp("behind"), trustme.CA()
    trust = ssl.create_default_context()
    authority.configure_trust(trust)
    options = ("--trusted-proxy", "127.0.0.1", "--public-host", NAME, "--log-requests", "yes")
    readme = (repository / "docs/how-to/own_server.md").read_text(encoding="utf-8")
    with ExitStack() as stack:
        _, address = stack.enter_context(
            server(folder / "data", model, folder / "log", *options, BREASTRIG_TOKEN=TOKEN)
        )
        port = int(address.rstrip("/").rsplit(":", 1)[1])
        caddyfile = repository / "server/packaging/deploy/Caddyfile"
        proxy_ports = {
            "nginx": stack.enter_context(in_front_of(port, readme, authority)),
            "caddy": stack.enter_context(caddy_in_front_of(port, caddyfile, NAME, authority, folder)),
        }

        def client(
            address: str = "127.0.0.1", host: str = NAME, through: str = "nginx", **headers: str
        ) -> httpx.Client:
            made = httpx.Client(
                base_url=f"https://127.0.0.1:{proxy_ports[through]}",
                headers={"Host": host, **headers},
                transport=_ByName(NAME, verify=trust, local_address=address),
                timeout=PATIENCE_S,
            )
            return stack.enter_context(made)

        yield Behind(port, proxy_ports, client, trust, folder / "log")


class _ByName(httpx.HTTPTransport):
    """Asks for the certificate of a name that this machine does not know."""

    def __init__(self, name: str, **options: object) -> None:
        super().__init__(**options)
        self._name = name

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        request.extensions["sni_hostname"] = self._name
        return super().handle_request(request)


@pytest.mark.slow
@pytest.mark.parametrize("proxy", ["nginx", "caddy"])
def test_a_browser_signs_in_over_tls_and_its_cookie_is_for_tls_only(behind: Behind, proxy: str) -> None:
    browser = behind.client(through=proxy, Origin=f"https://{NAME}")
    assert browser.get("/").headers["Location"] == "/sign-in"
    signed_in = browser.post("/sign-in", data={"token": TOKEN})
    assert (signed_in.status_code, signed_in.headers["Location"]) == (303, "/")
    cookie = signed_in.headers["Set-Cookie"]
    assert "Secure" in cookie
    assert "SameSite=Strict" in cookie
    with_cookie = {"Cookie": cookie.partition(";")[0]}
    assert browser.get("/api/meta", headers=with_cookie).status_code == 200
    foreign = with_cookie | {"Origin": "https://evil.example"}
    assert browser.delete("/api/scans/nobody", headers=foreign).status_code == 403
    assert browser.delete("/api/scans/nobody", headers=with_cookie).status_code == 204


def test_only_the_public_name_is_answered_to_outsiders(behind: Behind) -> None:
    assert behind.client(**BEARER).get("/api/meta").status_code == 200
    for host in ("evil.example", f"{NAME}.evil.example"):
        assert behind.client(host=host, **BEARER).get("/api/meta").status_code == 421


@pytest.mark.slow
def test_metrics_stay_closed_to_outsiders_whatever_they_say_of_themselves(behind: Behind) -> None:
    outsider = behind.client("127.0.0.30")
    for headers in ({}, {"X-Forwarded-For": "127.0.0.1"}, {"X-Forwarded-For": "127.0.0.1, 127.0.0.1"}):
        assert outsider.get("/metrics", headers=headers).status_code == 403
    assert outsider.get("/metrics", headers=BEARER).status_code == 200
    for source, status in (("127.0.0.1", 403), ("127.0.0.31", 200)):  # the first may be a proxy that says nothing
        with connected(behind.port, source) as direct:
            direct.sendall(request("/metrics"))
            assert answer(direct).status == status


@pytest.mark.slow
@pytest.mark.parametrize(("proxy", "net"), [("nginx", 40), ("caddy", 60)])
def test_guesses_are_counted_for_each_real_client_and_the_right_token_passes(
    behind: Behind, proxy: str, net: int
) -> None:
    guesser, colleague = (behind.client(f"127.0.0.{net + each}", through=proxy) for each in (0, 1))
    most = rate_limits.PER_MINUTE["bearer"].amount
    wrong = [
        {"Authorization": f"Bearer guess-{number}", "X-Forwarded-For": f"8.8.8.{number}"} for number in range(most + 1)
    ]
    codes = [guesser.get("/api/meta", headers=headers).status_code for headers in wrong]
    assert codes == [401] * most + [429]
    assert colleague.get("/api/meta", headers=wrong[0]).status_code == 401
    assert guesser.get("/api/meta", headers=BEARER).status_code == 200
    signs_in = [guesser.post("/sign-in", data={"token": "wrong"}).status_code for _ in range(21)]
    assert signs_in == [401] * 20 + [429]
    assert colleague.post("/sign-in", data={"token": "wrong"}).status_code == 401


@pytest.mark.slow
@pytest.mark.parametrize("proxy", ["nginx", "caddy"])
def test_events_come_through_as_they_happen(behind: Behind, torso: bytes, proxy: str) -> None:
    client = behind.client(through=proxy, **BEARER)
    made = client.post("/api/scans", files={"file": ("torso.ply", torso)})
    assert made.status_code == 201
    body = {"scan": made.json()["id"], "drawing": None, "preset": "paper"}  # goes on for ten seconds
    fit = client.post("/api/fits", json=body).json()["links"]
    kinds: list[str] = []
    with client.stream("GET", fit["events"]) as stream:
        for line in stream.iter_lines():
            if line.startswith("event: "):
                kinds.append(line[7:])
            if kinds.count("iterated") == 3:
                break
        assert client.get(fit["self"]).json()["state"] == "running"
    assert client.post(fit["cancel"]).status_code == 202
    assert client.delete(made.json()["links"]["self"]).status_code == 204


@pytest.mark.parametrize("proxy", ["nginx", "caddy"])
def test_uploads_of_strangers_are_refused_with_our_own_sentence(behind: Behind, torso: bytes, proxy: str) -> None:
    files = {"file": ("torso.ply", torso * 40)}  # 5 MB, more than any buffer on the way
    refused = behind.client(through=proxy).post("/api/scans", files=files)
    assert (refused.status_code, refused.headers["Content-Type"]) == (401, "application/problem+json")


@pytest.mark.parametrize("proxy", ["nginx", "caddy"])
def test_too_large_an_upload_is_refused_with_our_own_sentence_before_it_is_sent(behind: Behind, proxy: str) -> None:
    announced = {"Content_Type": "multipart/form-data; boundary=b", "Content_Length": 1_074_000_000}
    with (
        connected(behind.proxy_ports[proxy]) as plain,
        behind.trust.wrap_socket(plain, server_hostname=NAME) as connection,
    ):
        connection.sendall(request("/api/scans", "POST", Host=NAME, **announced, **BEARER))
        too_large = answer(connection)
    assert too_large.status == 413
    assert b"larger than 1073 MB" in too_large.body


@pytest.mark.slow
def test_nobody_else_is_believed(behind: Behind) -> None:
    forged = {"X_Forwarded_For": "8.8.8.8", "X_Forwarded_Proto": "https", "X_Forwarded_Host": NAME}

    def asked(source: str, method: str = "GET", address: str = "/api/meta", body: bytes = b"", **more: object):
        with connected(behind.port, source) as direct:
            direct.sendall(request(address, method, body, **forged, **more))
            return answer(direct)

    form = {"body": f"token={TOKEN}".encode(), "Content_Type": "application/x-www-form-urlencoded"}
    assert "Secure" not in asked("127.0.0.50", "POST", "/sign-in", **form).headers["set-cookie"]
    assert "Secure" in asked("127.0.0.1", "POST", "/sign-in", **form).headers["set-cookie"]
    assert asked("127.0.0.50", Host="evil.example", **BEARER).status == 421
    assert asked("127.0.0.1", Host="evil.example", **BEARER).status == 200
    most = rate_limits.PER_MINUTE["bearer"].amount
    codes = {asked("127.0.0.51", Authorization="Bearer wrong").status for _ in range(most + 1)}
    assert codes == {401, 429}
    with connected(behind.port, "127.0.0.52") as another:
        another.sendall(request("/api/meta", Authorization="Bearer wrong"))
        assert answer(another).status == 401


def test_the_log_names_no_client(behind: Behind) -> None:
    assert behind.client().get("/healthz").status_code == 200
    until(lambda: "/healthz" in behind.log.read_text(), "its line in the log")
    assert "127.0.0" not in behind.log.read_text()
