"""An image is kept with its scan, shown to its owner, and goes with it."""

import io
from collections.abc import Iterator

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.image_uploads import AFFINE, IMAGE, SHAPE, read_upload_of_image
from helpers.problems import problem

from breastrig.scan.kept_image import read_image
from breastrig.service.scans import uploads
from breastrig.service.service import Service


@pytest.fixture
def scan(client: FlaskClient, torso: bytes, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict]:
    monkeypatch.setattr(uploads, "read_upload", read_upload_of_image)
    answer = client.post("/api/scans", data={"file": (io.BytesIO(torso), "image.zip")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    yield answer.json
    client.delete(answer.json["links"]["self"])


def test_the_voxels_come_back_with_their_place(client: FlaskClient, service: Service, scan: dict) -> None:
    assert scan["image"] == {"shape": list(SHAPE), "to_scan": AFFINE.tolist(), "bytes": 105}
    assert client.get(scan["links"]["self"]).json == scan
    answer = client.get(scan["links"]["volume"])
    assert (answer.status_code, answer.mimetype) == (200, "application/octet-stream")
    assert answer.headers["Cache-Control"] == "no-store"
    found = np.frombuffer(answer.data, np.uint8).reshape(SHAPE, order="F")
    assert np.array_equal(found, IMAGE.values)
    folder = service.storage.files.scan(scan["id"])
    assert {path.name for path in folder.iterdir()} == {
        "scan.json", "scan.stored", "mesh.glb", "thumbnail.png", "volume.npz",
    }  # fmt: skip
    kept = read_image(folder / "volume.npz")
    assert np.array_equal(kept.values, IMAGE.values)
    assert (folder / "volume.npz").stat().st_mode & 0o077 == 0


def test_it_is_listed_as_an_image(client: FlaskClient, scan: dict) -> None:
    listed = client.get(scan["links"]["patient"]).json
    assert listed is not None
    assert [each["kind"] for each in listed["scans"]] == ["image"]


def test_it_moves_and_is_deleted_with_its_scan(client: FlaskClient, service: Service, scan: dict) -> None:
    moved = client.put(f"/api/scans/{scan['id']}/patient", json={"patient": None})
    assert moved.status_code == 200, moved.json
    [kept] = service.storage.root.rglob("volume.npz")
    assert kept.parent.parent.parent.name == moved.json["id"]
    assert client.get(scan["links"]["volume"]).status_code == 200
    assert client.delete(scan["links"]["self"]).status_code == 204
    assert list(service.storage.root.rglob("volume.npz")) == []
    assert "no such scan" in problem(client.get(scan["links"]["volume"]), 404)


def test_a_surface_has_none(client: FlaskClient, scan_id: str) -> None:
    scan = client.get(f"/api/scans/{scan_id}").json
    assert scan is not None
    assert (scan["image"], scan["links"]["volume"]) == (None, None)
    assert "has no image" in problem(client.get(f"/api/scans/{scan_id}/volume"), 404)
