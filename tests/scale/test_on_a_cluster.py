"""What the service promises of fits holds with a Dask cluster on its machine, too; the rest is that of tests/api."""

import fcntl
import io
import os
import signal
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from helpers import fake_fit
from helpers.blank_pictures import blank_pictures_in_reports
from helpers.installations import Large
from helpers.installed_service import Running, serving
from helpers.on_disk import kept_below
from helpers.waiting import ended, stored_events, until

from breastrig.gltf.read_rig import default_rig_path
from breastrig.storage.documents.events import events_after
from breastrig.storage.documents.fits import get_fit
from breastrig.use.fit import run_fit

pytestmark = pytest.mark.long

KINDS = ["started", *["iterated"] * 4, "done"]


def uploaded(running: Running, torso: bytes) -> dict[str, Any]:
    answer = running.client.post("/api/scans", data={"file": (io.BytesIO(torso), "a name of a patient.ply")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    return answer.json


def asked(running: Running, scan: dict[str, Any], **wishes: object) -> dict[str, Any]:
    answer = running.client.post("/api/fits", json={"scan": scan["id"], "drawing": None, **wishes})
    assert answer.status_code == 202, answer.json
    assert answer.json is not None
    return answer.json


def kinds(running: Running, fit: dict[str, Any]) -> list[str]:
    """The fit's events, after a look at whether it is numbered without a gap."""
    records = running.client.get(fit["links"]["events"] + ".json?limit=1000").json["events"]
    assert [one["id"] for one in records] == list(range(1, len(records) + 1))
    return [one["event"]["kind"] for one in records]


@pytest.fixture(scope="module")
def scan(running: Running, torso: bytes) -> dict[str, Any]:
    """One for all who do not delete it."""
    return uploaded(running, torso)


def test_an_upload_is_read_and_can_be_looked_at(running: Running, scan: dict[str, Any], torso: bytes) -> None:
    assert scan["triangles"] > 100
    mesh = running.client.get(scan["links"]["mesh"])
    assert (mesh.status_code, mesh.data[:4], mesh.content_length) == (200, b"glTF", len(mesh.data))
    bad = running.client.post("/api/scans", data={"file": (io.BytesIO(b"no scan"), "x.ply")})
    assert bad.status_code == 422
    kept = kept_below(running.root)
    assert torso not in kept  # a file of our own is, with the same triangles and no words
    assert b"faces.npy" in kept
    assert b"a name of a patient" not in kept
    assert b"no scan" not in kept


def test_a_fit_stores_its_events_once_and_from_any_number(running: Running, scan: dict[str, Any]) -> None:
    fit = asked(running, scan)
    events = stored_events(running.service, fit["id"])
    assert [event.kind for event in events] == KINDS
    assert stored_events(running.service, fit["id"], after=3) == events[3:]
    assert kinds(running, fit) == KINDS
    stream = running.client.get(fit["links"]["events"], headers={"Last-Event-ID": "4"}).get_data(as_text=True)
    assert [line for line in stream.splitlines() if line.startswith("id:")] == ["id: 5", "id: 6"]


def test_more_fits_than_workers_all_run(running: Running, scan: dict[str, Any]) -> None:
    fits = [asked(running, scan) for _ in range(3)]
    assert {ended(running.service, fit["id"]).state for fit in fits} == {"done"}
    assert all(kinds(running, fit) == KINDS for fit in fits)


def test_cancelling_ends_a_running_fit_and_frees_its_worker(running: Running, scan: dict[str, Any]) -> None:
    fits = [asked(running, scan, preset="paper") for _ in range(3)]

    def state(fit: dict[str, Any]) -> dict[str, Any]:
        return running.client.get(fit["links"]["self"]).json

    until(lambda: all(state(fit)["iterations"] > 1 for fit in fits[:2]), "two running fits")
    for fit in fits:
        assert running.client.post(fit["links"]["cancel"]).json["state"] == "cancelled"
    assert [kinds(running, fit)[-1] for fit in fits] == ["cancelled"] * 3
    assert ended(running.service, asked(running, scan)["id"]).state == "done"
    assert running.client.get(fits[0]["links"]["result"]).status_code == 409


def test_deleting_leaves_nothing_of_a_finished_and_a_running_fit(running: Running, torso: bytes) -> None:
    scan = uploaded(running, torso)
    done = asked(running, scan)
    ended(running.service, done["id"])
    running.client.post(done["links"]["shares"], json={})
    busy = [asked(running, scan, preset="paper") for _ in range(3)]
    until(lambda: running.client.get(busy[1]["links"]["self"]).json["iterations"] > 1, "a running fit")
    assert running.client.delete(scan["links"]["self"]).status_code == 204
    kept = kept_below(running.root)
    for name in (scan["id"], done["id"], *(fit["id"] for fit in busy)):
        assert name.encode() not in kept
    for links in (scan["links"]["mesh"], done["links"]["result"], busy[0]["links"]["self"]):
        assert running.client.get(links).status_code == 404
    for file in (Path(tempfile.gettempdir()) / f"breastrig-{os.getuid()}").glob("*.lock"):
        with suppress(FileNotFoundError):  # others may be at work
            lock = os.open(file, os.O_RDONLY)
            with pytest.raises(BlockingIOError):  # nobody's would be one that a killed process has left
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.close(lock)


def test_after_a_restart_every_fit_goes_on(large: Large, model: Path, torso: bytes, tmp_path: Path) -> None:
    with serving(large, tmp_path / "data", model, fake_fit.unhurried) as running:
        scan = uploaded(running, torso)
        fits = [asked(running, scan) for _ in range(3)]
        until(lambda: running.client.get(fits[1]["links"]["self"]).json["iterations"] > 0, "a running fit")
    with serving(large, tmp_path / "data", model) as running:
        assert {ended(running.service, fit["id"]).state for fit in fits} == {"done"}
        assert all(kinds(running, fit) == KINDS for fit in fits)
        assert running.client.get(fits[0]["links"]["result"]).status_code == 200


def test_a_real_fit_and_all_that_is_made_of_it(large: Large, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blank_pictures_in_reports(monkeypatch)
    with serving(large, tmp_path / "data", default_rig_path(), run_fit) as running:
        scan = running.client.post("/api/examples/standing").json
        fit = asked(running, scan, landmarks=scan["example_landmarks"]["landmarks"], drawing="lumpectomy")
        assert ended(running.service, fit["id"]).state == "done"
        result = running.client.get(fit["links"]["result"]).json
        assert result["surface_distance_mm"]["mean"] < 3.0
        report = running.client.get(fit["links"]["report"]).data
        assert report.startswith(b"%PDF")
        assert report not in kept_below(running.root)  # it is kept in memory only
        assert running.client.get(fit["links"]["report"]).data == report
        wish = {"from_fit": fit["id"], "to_fit": fit["id"]}
        assert running.client.post("/api/transfers", json=wish).status_code == 201


@pytest.mark.soak
def test_when_a_worker_of_the_cluster_is_killed_every_fit_is_executed_once(
    large: Large, model: Path, torso: bytes, tmp_path: Path
) -> None:
    # The last test: it leaves the cluster with one worker.
    killed, kept = large.cluster.workers
    with serving(large, tmp_path / "data", model, fake_fit.unhurried_or_slow) as running:
        scan = uploaded(running, torso)
        fits = [asked(running, scan, preset="paper") for _ in range(2)]
        fits += [asked(running, scan) for _ in range(4)]
        storage = running.service.storage
        until(
            lambda: all(get_fit(storage, fit["id"]).iterations > 0 for fit in fits[:2]), "a running fit on each worker"
        )
        os.kill(killed.pid, signal.SIGKILL)
        assert {ended(running.service, fit["id"]).state for fit in fits} == {"done"}
        for fit in fits:
            events = events_after(storage, fit["id"], 0)
            assert [(event.number, event.kind) for event in events] == list(enumerate(KINDS, start=1))
            assert running.client.get(fit["links"]["result"]).json["iterations"] == 3
        attempts = sorted(get_fit(storage, fit["id"]).attempt for fit in fits)
        assert attempts == [1, 1, 1, 1, 1, 2]  # only the one that the killed worker was at was begun again
        assert kept.poll() is None
