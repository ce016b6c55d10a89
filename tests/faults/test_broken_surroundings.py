"""A worker killed, a full disk, an index or a case that others hold, clients who leave: each fit has an honest end."""

import os
import signal
import socket
import sqlite3
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest
from helpers.fault_table import fit_folder, left_over, outcome, wait_for_ends
from helpers.real_server import alive, children, server
from helpers.small_disk import fill, small_disk
from helpers.waiting import PATIENCE_S, until

from breastrig.cases.layout import CLAIM
from breastrig.cases.writing import locked
from breastrig.index.file import current

pytestmark = pytest.mark.soak

DIED = "The fit's process ended unexpectedly"


def asked(client: httpx.Client, torso: bytes, count: int, **more: object) -> list[dict[str, str]]:
    """The links of so many fits of one new scan."""
    scan = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
    return [
        client.post("/api/fits", json={"scan": scan, "drawing": None, **more}).json()["links"] for _ in range(count)
    ]


def ends(client: httpx.Client, fits: list[dict[str, str]], log: Path) -> list[dict[str, Any]]:
    """The fits once all have ended; the events of each are whole and agrees with the state."""
    wait_for_ends(client, ids(fits), log)
    found = [client.get(links["self"]).json() for links in fits]
    for fit, links in zip(found, fits, strict=True):
        records = client.get(links["events"] + ".json?limit=1000").json()["events"]
        assert [one["id"] for one in records] == list(range(1, fit["last_event"] + 1))
        assert records[-1]["event"]["kind"] == fit["state"]
        assert client.get(links["result"]).status_code == (200 if fit["state"] == "done" else 409)
    return found


def ids(fits: list[dict[str, str]]) -> list[str]:
    return [links["self"].rsplit("/", 1)[1] for links in fits]


@dataclass(frozen=True)
class Running:
    process: subprocess.Popen[str]
    client: httpx.Client
    data: Path
    log: Path


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory, model: Path) -> Iterator[Running]:
    """One server that has to live through all that needs no disk of its own."""
    folder = tmp_path_factory.mktemp("running")
    with (
        server(folder / "data", model, folder / "log", FAKE_FIT="unhurried") as (process, address),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        yield Running(process, client, folder / "data", folder / "log")


def test_a_killed_worker_takes_one_fit_with_it(running: Running, torso: bytes, note) -> None:
    process, client = running.process, running.client
    fits = asked(client, torso, 5)
    held: dict[str, set[int]] = {}  # whichever fit runs now: on a busy machine the first may be over already

    def found() -> bool:
        pids = children(process.pid)
        held.update({fit_id: _holders(fit_folder(running.data, fit_id), pids) for fit_id in ids(fits)})
        return any(held.values())

    until(found, "the process of a fit")
    hit = next(fit_id for fit_id in ids(fits) if held[fit_id])
    for pid in held[hit]:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    last = {fit["id"]: fit for fit in ends(client, fits, running.log)}
    assert last[hit]["state"] == "done" or last[hit]["reason"].startswith(DIED)
    assert [fit["state"] for fit_id, fit in last.items() if fit_id != hit] == ["done"] * 4
    assert alive({process.pid})
    found = outcome(client, running.data, ids(fits))
    assert (found.done, found.failed) in ((5, 0), (4, 1))
    note("a worker killed", found)


def test_killed_processes_that_only_wait_for_work_are_not_missed(running: Running, torso: bytes, note) -> None:
    process, client = running.process, running.client
    fits = asked(client, torso, 3)
    folders = [fit_folder(running.data, fit_id) for fit_id in ids(fits)]
    pids = children(process.pid)
    workers = {pid for pid in pids if not children(pid) and _is_fork(pid)}
    for pid in workers - {holder for folder in folders for holder in _holders(folder, pids)}:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    fits += asked(client, torso, 2)
    ends(client, fits, running.log)
    found = outcome(client, running.data, ids(fits))
    assert found.done >= 3  # two may have begun in processes that were thought to wait
    note("processes killed that waited for work", found)


def _is_fork(pid: int) -> bool:
    """Whether the process came from the fork server, and is not the one that tracks resources."""
    with suppress(OSError):
        return b"forkserver" in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False


def _holders(folder: Path, pids: set[int]) -> set[int]:
    """The processes that are at work at the fit of that folder."""
    found = set()
    for pid in pids:
        with suppress(OSError):
            if any(os.readlink(link) == str(folder / CLAIM) for link in Path(f"/proc/{pid}/fd").iterdir()):
                found.add(pid)
    return found


def test_a_locked_index_makes_fits_wait_and_loses_none(running: Running, torso: bytes, note) -> None:
    client = running.client
    fits = asked(client, torso, 4)
    file = current(running.data)
    assert file is not None
    with closing(sqlite3.connect(file, isolation_level=None, timeout=PATIENCE_S)) as other:
        other.execute("BEGIN IMMEDIATE")
        time.sleep(1.5)  # longer than all four would take
        other.execute("COMMIT")
    last = ends(client, fits, running.log)
    assert [fit["state"] for fit in last] == ["done"] * 4
    note("index locked for 1.5 s", outcome(client, running.data, ids(fits)))


def test_a_case_that_another_program_holds_makes_ends_and_plans_wait_and_loses_none(
    running: Running, torso: bytes
) -> None:
    client = running.client
    fits = asked(client, torso, 4)
    scan = client.get(f"/api/scans/{client.get(fits[0]['self']).json()['scan']}").json()
    items = [{"kind": "note", "id": "n", "scan": scan["id"], "text": "smaller"}]
    saved: list[httpx.Response] = []

    def save() -> None:
        saved.append(client.put(scan["links"]["plan"], json={"items": items}, headers={"If-Match": '"0"'}))

    plan = threading.Thread(target=save)
    with locked(running.data / "cases" / scan["patient"]):
        plan.start()
        time.sleep(1.5)
        assert saved == []
        assert client.get(scan["links"]["plan"]).json()["items"] == []
        assert "done" not in [client.get(links["self"]).json()["state"] for links in fits]
    plan.join()
    assert saved[0].status_code == 200
    assert [fit["state"] for fit in ends(client, fits, running.log)] == ["done"] * 4
    assert client.get(scan["links"]["plan"]).json()["items"][0]["text"] == "smaller"
    assert left_over(running.data) == []


def test_a_client_gone_in_the_middle_of_an_upload_leaves_nothing(running: Running, torso: bytes, note) -> None:
    client = running.client
    kept = len(list(running.data.glob("cases/*/scans/*")))
    address = (client.base_url.host, client.base_url.port)
    head = (
        "POST /api/scans HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=b\r\n"
        f"Content-Length: {len(torso) + 1000}\r\n\r\n"
        '--b\r\nContent-Disposition: form-data; name="file"; filename="torso.ply"\r\n\r\n'
    )
    for _ in range(5):
        with socket.create_connection(address, timeout=PATIENCE_S) as connection:
            connection.sendall(head.encode() + torso[: len(torso) // 2])
    fits = asked(client, torso, 2)
    assert [fit["state"] for fit in ends(client, fits, running.log)] == ["done"] * 2
    assert len(list(running.data.glob("cases/*/scans/*"))) == kept + 1
    note("5 clients gone in the middle of an upload", outcome(client, running.data, ids(fits)))


def test_clients_gone_in_the_middle_of_a_stream_stop_no_fit(running: Running, torso: bytes, note) -> None:
    client = running.client
    fits = asked(client, torso, 3)
    for links in fits * 4:
        with client.stream("GET", links["events"]) as stream:
            next(stream.iter_text())
    last = ends(client, fits, running.log)
    assert [fit["state"] for fit in last] == ["done"] * 3
    note("12 clients gone in the middle of a stream", outcome(client, running.data, ids(fits)))


def test_a_full_disk_fails_fits_with_a_sentence_and_loses_none(
    tmp_path: Path, model: Path, torso: bytes, note: Callable[[str, str], None]
) -> None:
    log = tmp_path / "log"
    with (
        small_disk(tmp_path / "disk", 24) as disk,
        server(disk / "data", model, log, FAKE_FIT="mostly_patient") as (process, address),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        kept = asked(client, torso, 2)
        before = [client.get(links["result"]).content for links, _ in zip(kept, ends(client, kept, log), strict=True)]
        running = asked(client, torso, 2, preset="paper")  # write events for ten seconds
        waiting = asked(client, torso, 2)
        until(lambda: all(client.get(f["self"]).json()["iterations"] for f in running), "two running fits")
        ballast = fill(disk)
        refused = client.post("/api/scans", files={"file": ("torso.ply", torso)})
        assert refused.status_code in (503, 507)
        assert refused.headers["Content-Type"] == "application/problem+json"
        until(lambda: client.get("/readyz").status_code == 503, "a service that knows")
        assert [client.get(links["result"]).content for links in kept] == before
        time.sleep(2.0)  # until what was set aside for writing is used up
        ballast.unlink()
        last = ends(client, running + waiting, log)
        assert [fit["state"] for fit in last[:2]] == ["failed"] * 2
        assert all("stored" in fit["reason"] or "written" in fit["reason"] for fit in last if fit["reason"])
        again = ends(client, asked(client, torso, 2), log)
        assert [fit["state"] for fit in again] == ["done"] * 2
        full, after = (ids(running + waiting), ids(kept) + [fit["id"] for fit in again])
        note("disk full while fits run", outcome(client, disk / "data", full))
        note("disk full before and after", outcome(client, disk / "data", after))
        process.terminate()
        process.wait(timeout=PATIENCE_S)
