"""What the service promises, with processes of its own and with a Dask cluster on its machine: the same tests."""

import errno
import fcntl
import io
import json
import os
import signal
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from helpers import fake_fit
from helpers.installations import Large
from helpers.installed_service import Running, serving
from helpers.on_disk import kept_below
from helpers.problems import problem
from helpers.waiting import ended, stored_events, until

from breastrig.core.errors import BadSettings
from breastrig.gltf.read_rig import default_rig_path
from breastrig.storage.documents.events import events_after
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.storage import Storage
from breastrig.use.fit import run_fit

pytestmark = pytest.mark.long

FILES = ("result", "fitted_glb", "fitted_ply", "drawing", "distances")
KINDS = ["started", *["iterated"] * 4, "done"]


def uploaded(running: Running, torso: bytes) -> dict[str, Any]:
    answer = running.client.post("/api/scans", data={"file": (io.BytesIO(torso), "a name of a patient.ply")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    return answer.json


def asked(running: Running, scan: dict[str, Any], **wishes: object) -> dict[str, Any]:
    headers = {"Idempotency-Key": str(wishes.pop("key"))} if "key" in wishes else {}
    answer = running.client.post("/api/fits", json={"scan": scan["id"], "drawing": None, **wishes}, headers=headers)
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


@pytest.fixture(scope="module")
def done(running: Running, scan: dict[str, Any]) -> dict[str, Any]:
    """A fit that has ended well."""
    fit = asked(running, scan)
    assert ended(running.service, fit["id"]).state == "done"
    return fit


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


def test_landmarks_and_proposals_are_kept_with_the_scan(running: Running, scan: dict[str, Any]) -> None:
    picked = {"nipple_L": [70.0, 350.0, 120.0]}
    for _ in range(2):
        assert running.client.put(scan["links"]["landmarks"], json={"landmarks": picked}).status_code == 200
    assert running.client.get(scan["links"]["landmarks"]).json["landmarks"] == picked
    for _ in range(2):
        assert list(running.client.get(scan["links"]["proposed"]).json["landmarks"]) == ["nipple_L"]


def test_a_fit_stores_its_events_once_and_from_any_number(running: Running, scan: dict[str, Any]) -> None:
    fit = asked(running, scan)
    events = stored_events(running.service, fit["id"])
    assert [event.kind for event in events] == KINDS
    assert stored_events(running.service, fit["id"], after=3) == events[3:]
    assert kinds(running, fit) == KINDS
    stream = running.client.get(fit["links"]["events"], headers={"Last-Event-ID": "4"}).get_data(as_text=True)
    assert [line for line in stream.splitlines() if line.startswith("id:")] == ["id: 5", "id: 6"]


def test_results_have_an_etag_and_ranges(running: Running, done: dict[str, Any]) -> None:
    for name in FILES:
        place = done["links"][name]
        whole = running.client.get(place)
        assert (whole.status_code, whole.headers["Accept-Ranges"]) == (200, "bytes")
        etag = whole.headers["ETag"]
        again = running.client.get(place, headers={"If-None-Match": etag})
        assert (again.status_code, again.data, again.headers["ETag"]) == (304, b"", etag)
        part = running.client.get(place, headers={"Range": "bytes=3-7"})
        assert (part.status_code, part.data) == (206, whole.data[3:8])
        assert part.headers["Content-Range"] == f"bytes 3-7/{len(whole.data)}"
        last = running.client.get(place, headers={"Range": "bytes=-4", "If-Range": etag})
        assert (last.status_code, last.data) == (206, whole.data[-4:])
        beyond = running.client.get(place, headers={"Range": f"bytes={len(whole.data)}-"})
        assert beyond.status_code == 416
        head = running.client.head(place)
        assert (head.status_code, head.content_length, head.data) == (200, len(whole.data), b"")
    told = running.client.get(done["links"]["events"] + ".json").json["events"][-1]["event"]["result"]
    assert json.loads(running.client.get(done["links"]["result"]).data) == told


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


def test_the_same_request_again_starts_no_second_fit(running: Running, scan: dict[str, Any]) -> None:
    first, again = (asked(running, scan, key="a-key-of-this-test-" + scan["id"]) for _ in range(2))
    assert first["id"] == again["id"]
    refused = running.client.post(
        "/api/fits",
        json={"scan": scan["id"], "preset": "paper"},
        headers={"Idempotency-Key": "a-key-of-this-test-" + scan["id"]},
    )
    assert refused.status_code == 422


def test_a_share_opens_until_it_is_revoked(running: Running, scan: dict[str, Any], done: dict[str, Any]) -> None:
    share = running.client.post(done["links"]["shares"], json={"scan": "full"}).json
    token = share["url"].removeprefix("/s#")
    assert token.encode() not in kept_below(running.root)
    visitor = running.client.application.test_client()
    shown = visitor.post("/api/shared/open", json={"token": token}).json
    assert visitor.get(shown["links"]["result"]).json == running.client.get(done["links"]["result"]).json
    assert visitor.get(shown["links"]["mesh"]).data.startswith(b"glTF")
    assert running.client.post(share["links"]["refresh"]).status_code == 200
    assert visitor.get(shown["links"]["distances"]).status_code == 200
    plain = running.client.post(done["links"]["shares"], json={"scan": "plain"}).json["url"].removeprefix("/s#")
    mesh = visitor.get(visitor.post("/api/shared/open", json={"token": plain}).json["links"]["mesh"])
    assert (mesh.status_code, mesh.data[:4]) == (200, b"glTF")
    assert running.client.delete(share["links"]["self"]).status_code == 204
    assert visitor.get(shown["links"]["result"]).status_code == 410
    assert visitor.get(shown["links"]["close"]).status_code == 405
    assert visitor.post(shown["links"]["close"]).status_code == 204
    assert visitor.get(shown["links"]["result"]).status_code == 401
    assert visitor.post("/api/shared/open", json={"token": token}).status_code == 410


def test_what_cannot_be_an_id_is_not_found_or_refused(running: Running) -> None:
    for place in ("/api/scans/nobody", "/api/fits/nobody", "/api/scans/a%00b", "/api/fits/%F0%9F%A6%B4"):
        assert running.client.get(place).status_code in (404, 422)


def test_files_that_cannot_be_reached_for_now_give_503(
    running: Running, done: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_asked: object) -> None:
        raise OSError(errno.EIO, "the disk does not answer")

    monkeypatch.setattr(running.service.storage.files, "find", gone)
    answer = running.client.get(done["links"]["result"])
    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "10")
    assert problem(answer, 503) == "The service cannot reach its files at the moment; try again later."


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


def test_after_a_restart_every_fit_goes_on(installation, model: Path, torso: bytes, tmp_path: Path) -> None:
    with serving(installation, tmp_path / "data", model, fake_fit.unhurried) as running:
        scan = uploaded(running, torso)
        fits = [asked(running, scan) for _ in range(3)]
        until(lambda: running.client.get(fits[1]["links"]["self"]).json["iterations"] > 0, "a running fit")
    with serving(installation, tmp_path / "data", model) as running:
        assert {ended(running.service, fit["id"]).state for fit in fits} == {"done"}
        assert all(kinds(running, fit) == KINDS for fit in fits)
        assert running.client.get(fits[0]["links"]["result"]).status_code == 200


def test_a_second_server_on_the_same_place_is_refused(running: Running) -> None:
    elsewhere = Storage(running.root)
    with pytest.raises(BadSettings, match="Another BreastRig server uses"), elsewhere.exclusive():
        pass
    elsewhere.close()


def test_a_real_fit_and_all_that_is_made_of_it(large: Large, tmp_path: Path) -> None:
    """On one machine tests/api does the same, and more."""
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
