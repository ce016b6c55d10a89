"""An image is kept with its scan, shown to its owner, and goes with it."""

import gzip
import io
import json
from collections.abc import Iterator

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.dicom_files import NAME, SECRET
from helpers.example_image import LESIONS, example_image, example_segmentation
from helpers.image_uploads import AFFINE, IMAGE, SHAPE, read_upload_of_image
from helpers.label_maps import BODY_WORDS, LESION, PLAIN, RADIUS, coarse_labels, file_of, masks, seg
from helpers.on_disk import bytes_below
from helpers.problems import problem

from breastrig.execution.limits import UploadLimits
from breastrig.scan.images.added_lesions import LesionsRead
from breastrig.scan.kept_image import read_image
from breastrig.scan.piece import BallInside
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED
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


def add(client: FlaskClient, scan: dict, data: bytes, **fields: str):
    return client.post(f"/api/scans/{scan['id']}/lesions", data={"file": (io.BytesIO(data), "a"), **fields})


def planned(client: FlaskClient, scan: dict) -> list[dict]:
    plan = client.get(scan["links"]["plan"]).json
    assert plan is not None
    return plan["items"]


def test_the_voxels_come_back_with_their_place(client: FlaskClient, service: Service, scan: dict) -> None:
    assert scan["image"] == {"shape": list(SHAPE), "to_scan": AFFINE.tolist(), "bytes": 315}
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


def test_a_surface_has_none(client: FlaskClient, scan_id: str, torso: bytes) -> None:
    scan = client.get(f"/api/scans/{scan_id}").json
    assert scan is not None
    assert (scan["image"], scan["links"]["volume"]) == (None, None)
    assert "has no image" in problem(client.get(f"/api/scans/{scan_id}/volume"), 404)
    assert "made of no image" in problem(add(client, scan, torso), 422)


@pytest.mark.slow
def test_lesions_of_another_file_are_added_to_the_plan_once(client: FlaskClient, service: Service, scan: dict) -> None:
    note = {"kind": "note", "id": "mine", "scan": scan["id"], "text": "as it was"}
    own = {"kind": "lesion", "id": "own", "scan": scan["id"], "name": "Lesion 1", "center": [1, 2, 3], "radius_mm": 4}
    put = client.put(scan["links"]["plan"], json={"items": [note, own]}, headers={"If-Match": '"0"'})
    assert put.status_code == 200, put.json
    for is_new in (True, False):
        answer = add(client, scan, gzip.compress(coarse_labels()))
        assert answer.status_code == 200, answer.json
        assert answer.json is not None
        [lesion] = answer.json["lesions"]
        assert (lesion["name"], lesion["new"]) == ("Lesion 2", is_new)
        assert lesion["center"] == pytest.approx(LESION.tolist(), abs=0.5)
        assert lesion["radius_mm"] == pytest.approx(RADIUS, abs=0.2)
        assert [each["name"] for each in answer.json["segments"]] == ["Tissue 1", "Lesion 2", "Tissue 2"]
        items = planned(client, scan)
        assert [(each["kind"], each.get("name")) for each in items] == [
            ("note", None), ("lesion", "Lesion 1"), ("lesion", "Lesion 2"),
        ]  # fmt: skip
        assert (items[2]["scan"], items[2]["center"]) == (scan["id"], lesion["center"])
    assert list((service.storage.root / "incoming").iterdir()) == []
    chosen = add(client, scan, gzip.compress(coarse_labels()), segments=json.dumps({"2": "tissue"}), same_place="yes")
    assert chosen.json is not None
    assert chosen.json["lesions"] == []
    assert chosen.json["segments"][1]["why"] == "A person said so."


def test_what_holds_no_lesions_is_one_sentence(client: FlaskClient, service: Service, scan: dict, torso: bytes) -> None:
    assert "holds no lesions" in problem(add(client, scan, torso), 422)
    assert "empty" in problem(add(client, scan, b""), 422)
    problem(add(client, scan, torso, same_place="perhaps"), 422)
    assert "no such scan" in problem(add(client, {"id": "A" * 22}, torso), 404)
    assert planned(client, scan) == []
    assert list((service.storage.root / "incoming").iterdir()) == []


@pytest.mark.slow
def test_words_of_a_file_of_lesions_are_answered_once_and_kept_nowhere(
    client: FlaskClient, service: Service, scan: dict, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("DEBUG")
    name = "Zoe Quixote"
    answer = add(client, scan, gzip.compress(file_of(seg(masks(), {1: BODY_WORDS, 2: (name, *PLAIN[1:])}))))
    assert answer.status_code == 200, answer.json
    assert answer.json is not None
    assert [each["label"] for each in answer.json["segments"]] == ["Body Breast", f"{name} Tissue"]
    assert name not in json.dumps(client.get(scan["links"]["self"]).json) + caplog.text
    assert name not in json.dumps(planned(client, scan))
    assert b"Quixote" not in bytes_below(service.storage.root)


def upload(client: FlaskClient, data: bytes, **fields: str):
    return client.post("/api/scans", data={"file": (io.BytesIO(data), f"{NAME}.zip"), **fields})


@pytest.mark.slow
def test_which_series_is_asked_and_nothing_of_a_header_is_kept(
    client: FlaskClient, service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("DEBUG")
    data = example_image("t1 fs", "t2 tse")
    before = client.get("/api/scans").json
    asked = upload(client, data)
    assert (asked.status_code, asked.mimetype) == (422, "application/problem+json")
    assert asked.json is not None
    question = asked.json["question"]
    assert question["field"] == "series"
    assert len(question["choices"]) == 2
    assert all(choice["picture"].startswith("data:image/png;base64,") for choice in question["choices"])
    assert client.get("/api/scans").json == before
    assert list((service.storage.root / "incoming").iterdir()) == []
    answer = upload(client, data, series=question["choices"][1]["value"])
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    scan = answer.json
    assert scan["image"]["shape"] == [68, 54, 59]
    assert len(client.get(scan["links"]["volume"]).data) == scan["image"]["bytes"] == 68 * 54 * 59
    told = json.dumps(scan, ensure_ascii=False) + client.get(scan["links"]["patient"]).get_data(as_text=True)
    kept = bytes_below(service.storage.root)
    for word in (NAME, SECRET, "t1 fs", "t2 tse", "19700101"):
        assert word not in told + caplog.text
        assert word.encode() not in kept
    with np.load(service.storage.files.scan(scan["id"]) / "volume.npz") as arrays:
        assert set(arrays) == {"values", "affine", "frame"}
    assert "no such series" in problem(upload(client, data, series="another"), 422)
    assert client.delete(scan["links"]["self"]).status_code == 204


def test_only_a_zip_may_be_as_large_as_an_examination(
    client: FlaskClient, service: Service, monkeypatch: pytest.MonkeyPatch, torso: bytes
) -> None:
    limits = UploadLimits(file_bytes=len(torso) - 1, zip_bytes=len(torso))
    monkeypatch.setattr(service.uploads, "_limits", limits)
    assert "more than the 0 MB allowed" in problem(upload(client, torso), 413)
    assert "damaged" in problem(upload(client, b"PK\x03\x04" + torso[4:]), 422)
    assert "more than" in problem(upload(client, b"PK\x03\x04" + torso), 413)
    assert list((service.storage.root / "incoming").iterdir()) == []


@pytest.mark.slow
def test_whether_lesions_lie_in_the_image_is_asked_and_answered(client: FlaskClient, service: Service) -> None:
    answer = upload(client, example_image())
    assert answer.json is not None
    scan = answer.json
    wanted = 1e3 * read_scan(LESIONS).lesions[0].center
    asked = add(client, scan, example_segmentation("another"))
    assert asked.status_code == 422
    assert asked.json is not None
    question = asked.json["question"]
    assert (question["field"], [each["value"] for each in question["choices"]]) == ("same_place", ["yes", "no"])
    assert question["choices"][0]["picture"].startswith("data:image/png;base64,")
    assert planned(client, scan) == []
    assert "do not lie where the image does" in problem(
        add(client, scan, example_segmentation("another"), same_place="no"), 422
    )
    taken = add(client, scan, example_segmentation())  # of the same frame of reference nothing is asked
    again = add(client, scan, example_segmentation("another"), same_place="yes")
    assert (taken.status_code, again.status_code) == (200, 200)
    assert taken.json is not None
    assert again.json is not None
    assert [taken.json["lesions"][0]["new"], again.json["lesions"][0]["new"]] == [True, False]
    [lesion] = planned(client, scan)
    assert lesion["center"] == pytest.approx(wanted.tolist(), abs=1.0)
    assert b"Index lesion" not in bytes_below(service.storage.root)
    client.delete(scan["links"]["self"])


@pytest.mark.slow
def test_a_segmentation_in_the_zip_is_in_the_plan_or_said_to_be_left_out(client: FlaskClient) -> None:
    answer = upload(client, example_image("t1", beside=example_segmentation()))
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    assert [each["name"] for each in planned(client, answer.json)] == ["Lesion 1"]
    client.delete(answer.json["links"]["self"])
    asked = upload(client, example_image("t1", beside=example_segmentation("another")))
    assert asked.json is not None
    assert (asked.status_code, asked.json["question"]["field"]) == (422, "same_place")
    refused = upload(client, example_image("t1", beside=example_segmentation("another")), same_place="no")
    assert refused.status_code == 201, refused.json
    assert refused.json is not None
    assert planned(client, refused.json) == []
    assert any("left out: A person said that" in note for note in refused.json["notes"])
    client.delete(refused.json["links"]["self"])


@pytest.mark.parametrize("wall", [None, (np.array([[0.0, 0.0, 0.0], [9, 0, 0], [0, 0, 9]]), np.array([[0, 1, 2]]))])
@pytest.mark.parametrize("meanwhile", ["moved", "deleted"])
def test_a_scan_that_is_moved_or_deleted_while_its_lesions_are_read(
    client: FlaskClient,
    service: Service,
    scan: dict,
    torso: bytes,
    monkeypatch: pytest.MonkeyPatch,
    meanwhile: str,
    wall: tuple | None,
) -> None:
    def read(*_task: object) -> LesionsRead:
        if meanwhile == "moved":
            assert client.put(f"/api/scans/{scan['id']}/patient", json={"patient": None}).status_code == 200
        else:
            assert client.delete(scan["links"]["self"]).status_code == 204
        return LesionsRead((BallInside("Lesion 1", np.zeros(3), 5.0),), (), (), wall)

    monkeypatch.setattr(service.uploads, "_result", read)
    answer = add(client, scan, torso)
    if meanwhile == "deleted":
        assert "no such scan" in problem(answer, 404)
    else:
        assert answer.status_code == 200, answer.json
        assert [each["name"] for each in planned(client, client.get(scan["links"]["self"]).json)] == ["Lesion 1"]
        kept = read_scan(service.storage.files.scan(scan["id"]) / "scan.stored", STORED)
        assert (kept.wall is None) == (wall is None)
        if wall is not None and kept.wall is not None:
            np.testing.assert_allclose(1e3 * kept.wall[0], wall[0])
    assert list((service.storage.root / "incoming").iterdir()) == []
