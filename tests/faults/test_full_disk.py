"""Every call of the service on a full disk: what needs room is answered with 507, and no answer says where files lie.

Without a disk of its own: whatever a task in another process met is told as what it was.
"""

import errno
import json
import re
from pathlib import Path

import httpx
import pytest
from helpers.fault_table import wait_for_ends
from helpers.image_uploads import IMAGE
from helpers.real_server import server
from helpers.small_disk import fill, small_disk
from helpers.waiting import PATIENCE_S

from breastrig.cases.layout import VOLUME
from breastrig.core.errors import BadScan
from breastrig.scan.kept_image import write_image
from breastrig.service.fits.queue import DIED, UNWRITTEN, _why
from breastrig.service.scans.scan_search import Proposals
from breastrig.service.scans.uploads import Uploads

NIPPLE_MM = [70.0, 350.0, 120.0]
UPLOADS = (("post", "/api/scans"), ("post", "/api/scans/{scan_id}/lesions"))
FULL = OSError(errno.ENOSPC, "No space left on device", "/somewhere/secret/scan.bin")


class Broken:
    """In the place of a task's process."""

    def result(self, *_task: object) -> None:
        raise FULL


def test_a_reader_that_has_no_room_is_not_the_scans_fault() -> None:
    reading = object.__new__(Uploads)
    reading._processes = Broken()
    reading._limits = type("Limits", (), {"wall_s": 1.0})()
    with pytest.raises(OSError, match="No space left"):
        reading._read("scan", None)


def test_a_search_and_a_fit_that_have_no_room_say_so() -> None:
    search = object.__new__(Proposals)
    assert search._as_sentence(FULL) is FULL
    assert _why(FULL) == UNWRITTEN
    assert _why(OSError(errno.ECHILD, "gone")) == DIED
    assert _why(BadScan("No skin.")) == "No skin."


def bodies(api: httpx.Client, scan: str) -> dict[tuple[str, str], object]:
    """What calls that write are sent, where the example of the document would be refused before."""
    items = [{"kind": "note", "id": "a-note-of-hers", "scan": scan, "text": "smaller " * 200}]
    landmarks = {"schema": "breastrig/landmarks@1", "unit": "mm", "landmarks": {"nipple_L": NIPPLE_MM}}
    return {
        ("post", "/api/fits"): {"scan": scan, "drawing": None},
        ("put", "/api/scans/{scan_id}/landmarks"): landmarks,
        ("put", "/api/patients/{patient_id}/plan"): {"items": items},
        ("patch", "/api/patients/{patient_id}"): {"code": "another"},
        ("put", "/api/scans/{scan_id}/cuts"): {
            "cuts": [{"to_picture": [float(i % 5 == 0) for i in range(16)], "lasso": [[0, 0], [0.1, 0], [0, 0.1]]}]
        },
        ("post", "/api/fits/{fit_id}/shares"): {},
    }


def test_every_call_on_a_full_disk(tmp_path: Path, model: Path, torso: bytes) -> None:
    with (
        small_disk(tmp_path / "disk", 24) as disk,
        server(disk / "data", model, tmp_path / "log", FAKE_FIT="quick") as (process, address),
        httpx.Client(base_url=address, timeout=PATIENCE_S) as api,
    ):
        scan = api.post("/api/scans", files={"file": ("torso.ply", torso)}).json()
        [stored] = (disk / "data").rglob("scan.stored")
        write_image(IMAGE, stored.with_name(VOLUME))
        fit = api.post("/api/fits", json={"scan": scan["id"], "drawing": None}).json()["id"]
        wait_for_ends(api, [fit], tmp_path / "log")
        document = api.get("/api/openapi.json").json()
        ids = {"scan_id": scan["id"], "fit_id": fit, "patient_id": scan["patient"], "share_id": "0" * 32}
        ids |= {
            "version": "1",
            "iteration": "0",
            "name": "standing",
            "kind": "pp",
            "sha256": "0" * 64,
            "deleted_id": "0" * 22,
        }
        sent = bodies(api, scan["id"])
        fill(disk)
        answered = {}
        for path, calls in document["paths"].items():
            for method in calls.keys() & {"get", "put", "post", "patch"}:  # deleting frees
                if path.endswith("/events"):
                    continue  # a stream
                address = re.sub(r"\{(\w+)\}", lambda found: ids[found[1]], path)
                fill(disk)  # also what the database has just given back
                if (method, path) in UPLOADS:
                    answer = api.post(address, files={"file": ("torso.ply", torso)})
                else:
                    body = None if method == "get" else sent.get((method, path), {})
                    headers = {"If-Match": '"0"'} if path.endswith("/plan") else {}  # that nobody has begun
                    answer = api.request(method, address, json=body, headers=headers)
                answered[method, path] = answer.status_code
                told = answer.text if "json" in answer.headers.get("Content-Type", "") else ""
                assert answer.status_code != 500, (method, path, told)
                assert str(tmp_path) not in told, (method, path)
                assert "simplify" not in told, (method, path, told)
                if answer.status_code == 507:
                    assert "disk is full" in json.loads(told)["detail"]
        assert {call: answered[call] for call in [*UPLOADS, *sent]} == dict.fromkeys([*UPLOADS, *sent], 507)
        process.terminate()
        process.wait(timeout=PATIENCE_S)
    assert "Traceback" not in (tmp_path / "log").read_text()
