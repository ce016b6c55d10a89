"""The real thing over a socket: `breastrig serve` as a process, asked by httpx; only the numerics are stood in for."""

import json
import signal
import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import httpx
import pytest
from helpers.raw_http import answer, connected
from helpers.real_server import alive, children, read_events, server
from helpers.waiting import PATIENCE_S, until

from breastrig.api.access.security import HEADERS
from breastrig.api.config import STREAMS
from breastrig.cli.main import main

pytestmark = pytest.mark.long


@pytest.mark.slow
def test_a_server_that_is_killed_forgets_no_fit_and_leaves_no_process(
    tmp_path: Path, model: Path, torso: bytes
) -> None:
    """And no process of it inherits its secret."""
    data, log, token = tmp_path / "data", tmp_path / "log", "a-token-of-more-than-sixteen-characters"

    def asking(address: str) -> httpx.Client:
        return httpx.Client(base_url=address, headers={"Authorization": f"Bearer {token}"}, timeout=PATIENCE_S)

    with server(data, model, log, BREASTRIG_TOKEN=token) as (process, address), asking(address) as client:
        assert httpx.get(f"{address}api/meta", timeout=PATIENCE_S).status_code == 401
        scan_id = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
        body = {"scan": scan_id, "drawing": None}
        done = client.post("/api/fits", json=body).json()["links"]
        received = read_events(client, done["events"])
        running = [client.post("/api/fits", json=body | {"preset": "paper"}).json()["links"] for _ in range(4)]
        until(lambda: client.get(running[0]["self"]).json()["iterations"] > 1, "a running fit")
        first = client.get(running[0]["events"] + ".json?limit=3").json()["events"]
        begun = client.get(running[0]["self"]).json()
        below = children(process.pid)
        commands = [Path(f"/proc/{pid}/cmdline").read_bytes() for pid in below]
        environments = [Path(f"/proc/{pid}/environ").read_bytes() for pid in below]
        assert any(b"forkserver" in command for command in commands)  # every task's process is made of it
        assert any(b"PATH=" in environment for environment in environments)
        assert not any(token.encode() in environment for environment in environments)
        process.kill()
        process.wait()
        until(lambda: not alive(below), "the end of all processes")
    with server(data, model, log, BREASTRIG_TOKEN=token) as (_, address), asking(address) as client:
        assert read_events(client, done["events"]) == received
        fits = [client.get(links["self"]).json() for links in running]
        assert {fit["state"] for fit in fits} <= {"queued", "running"}
        assert fits[0]["last_event"] >= begun["last_event"]
        assert client.get(running[0]["events"] + ".json?limit=3").json()["events"] == first
        for links in running:
            client.post(links["cancel"])
    # Python's fork server may be met by the kill in the middle of a request, and says that in words of its own
    assert '"traceback"' not in log.read_text()


@pytest.fixture(scope="module")
def served(model: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, str]]:
    """Address of a server for tests that leave it as it is, and what it says of who may read: it has no token."""
    folder = tmp_path_factory.mktemp("server")
    with server(folder / "data", model, folder / "log") as (process, address):
        assert process.stdout is not None
        yield address, process.stdout.readline()


@pytest.fixture
def address(served: tuple[str, str]) -> str:
    return served[0]


def test_without_a_token_it_says_who_may_read(served: tuple[str, str]) -> None:
    address, said = served
    assert said.startswith("No token: every user and program of this machine can read")
    assert httpx.get(f"{address}api/patients", timeout=PATIENCE_S).status_code == 200


def test_a_scan_goes_in_and_the_fit_comes_out(address: str, torso: bytes) -> None:
    with httpx.Client(base_url=address, timeout=PATIENCE_S) as client:
        scan = client.post("/api/scans", files={"file": ("torso.ply", torso)}, data={"units": "auto"})
        assert scan.status_code == 201
        fit = client.post("/api/fits", json={"scan": scan.json()["id"], "drawing": "lumpectomy"}).json()["links"]
        live = read_events(client, fit["events"])
        assert [block.split("\n")[1] for block in live] == ["event: started", *["event: iterated"] * 4, "event: done"]
        assert read_events(client, fit["events"], **{"Last-Event-ID": "4"}) == live[4:]
        assert client.get(fit["events"], headers={"Last-Event-ID": "6"}).status_code == 204
        answer = client.get(fit["fitted_glb"])
        assert client.get(fit["fitted_glb"], headers={"If-None-Match": answer.headers["ETag"]}).status_code == 304


@pytest.mark.slow
def test_an_event_is_sent_when_it_happens(address: str, torso: bytes) -> None:
    """While the fit that it belongs to still runs, for seconds."""
    with httpx.Client(base_url=address, timeout=PATIENCE_S) as client:
        scan_id = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
        fit = client.post("/api/fits", json={"scan": scan_id, "drawing": None, "preset": "paper"}).json()["links"]
        with client.stream("GET", fit["events"]) as answer:
            next(line for line in answer.iter_lines() if line == "event: iterated")
            assert client.get(fit["self"]).json()["state"] == "running"
        client.post(fit["cancel"])


@pytest.mark.slow
def test_streams_up_to_the_cap_leave_room_for_other_calls_and_give_their_places_back(
    address: str, torso: bytes
) -> None:
    assert STREAMS >= 50
    with httpx.Client(base_url=address, timeout=PATIENCE_S) as client, ExitStack() as viewers:
        scan_id = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
        body = {"scan": scan_id, "drawing": None, "preset": "paper"}
        fits = [client.post("/api/fits", json=body).json()["links"] for _ in range(8)]
        fit = fits[-1]  # it waits for the others: there is something to watch for as long as this test lasts
        watched = f"{fit['events']}?after=100000"
        for _ in range(STREAMS):
            viewer = viewers.enter_context(socket.create_connection((client.base_url.host, client.base_url.port)))
            viewer.settimeout(PATIENCE_S)
            viewer.sendall(f"GET {watched} HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
            assert viewer.recv(1000).startswith(b"HTTP/1.1 200")
        refused = client.get(watched)
        assert (refused.status_code, refused.headers["Retry-After"]) == (503, "5")
        assert "events.json" in refused.json()["detail"]
        assert client.get(f"{fit['events']}.json").status_code == 200
        assert client.post("/api/scans", files={"file": ("torso.ply", torso)}).status_code == 201
        viewers.close()

        def free() -> bool:
            with client.stream("GET", watched) as answer:
                return answer.status_code == 200

        until(free, "a free place")
        for links in fits:
            client.post(links["cancel"])


def test_broken_http_is_answered_with_problem_details(address: str) -> None:
    port = int(address.rstrip("/").rsplit(":", 1)[1])
    for request, status in (
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n", 400),
        (b"POST /api/scans HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9000000000\r\n\r\n", 413),
    ):
        with connected(port) as connection:
            connection.sendall(request)
            found = answer(connection)
        assert found.status == status
        assert found.headers["content-type"] == "application/problem+json"
        assert {name: found.headers[name.lower()] for name in HEADERS} == HEADERS
        assert "server" not in found.headers


def refused(data: Path, model: Path, *arguments: str) -> list[str]:
    """The words of a command that starts no server."""
    return ["serve", "--data", str(data), "--model", str(model), *arguments]


@pytest.mark.parametrize(
    ("arguments", "token", "sentence"),
    [
        (["--host", "0.0.0.0"], None, "set BREASTRIG_TOKEN"),
        (["--host", "0.0.0.0"], "short", "too short"),
        (["--host", "nowhere.invalid"], "long enough to be a secret", "is not an address"),
        (["--model", "nothing.glb"], None, "nothing.glb cannot be read"),
    ],
)
def test_a_server_that_cannot_start_says_why_in_one_line(
    tmp_path: Path,
    model: Path,
    arguments: list[str],
    token: str | None,
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("BREASTRIG_TOKEN", raising=False)
    if token is not None:
        monkeypatch.setenv("BREASTRIG_TOKEN", token)
    assert main(refused(tmp_path, model, *arguments)) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert len(said.err.splitlines()) == 1
    assert said.out == ""


@pytest.mark.slow
def test_the_token_may_come_from_a_file_the_log_is_json_without_names_and_sigterm_ends_all(
    tmp_path: Path, model: Path, torso: bytes
) -> None:
    token, log = "a secret from a file of its own", tmp_path / "log"
    (tmp_path / "token").write_text(token)
    with (
        server(tmp_path / "data", model, log, "--token-file", str(tmp_path / "token"), FAKE_FIT="broken") as (
            process,
            address,
        ),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        assert client.get("/api/meta").status_code == 401
        client.headers["Authorization"] = f"Bearer {token}"
        scan = client.post("/api/scans", files={"file": ("Jane Doe.ply", torso)}).json()
        client.put(scan["links"]["landmarks"], json={"landmarks": {"nipple_L": [70, 350.7182, 120]}})
        fit = client.post("/api/fits", json={"scan": scan["id"], "drawing": None}).json()["links"]
        until(lambda: client.get(fit["self"]).json()["state"] == "failed", "the broken fit")
        until(lambda: "ZeroDivisionError" in log.read_text(), "its line in the log")
        below = children(process.pid)
        assert below
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=PATIENCE_S) == 0
        until(lambda: not alive(below), "the end of all processes")
        written = log.read_text()
    lines = [json.loads(line) for line in written.rpartition("\n")[0].splitlines()]
    assert any("ZeroDivisionError" in line.get("traceback", "") for line in lines)
    requests = {(line["method"], line["route"], line["status"]) for line in lines if "route" in line}
    assert {("GET", "/api/meta", 401), ("PUT", "/api/scans/<scan_id>/landmarks", 200)} <= requests
    assert not any(word in log.read_text() for word in ("Jane", token, "127.0.0.1", scan["id"], "350.7"))
