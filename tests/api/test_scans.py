import hashlib
import io
import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.named_scans import NAME, NAMED
from helpers.on_disk import kept_below
from helpers.problems import problem
from helpers.uploads import torso as torso_ply
from helpers.waiting import until

from breastrig.api.config import Config
from breastrig.service.service import Service
from breastrig.storage.documents.scans import get_scan

pytestmark = pytest.mark.long


def upload(client: FlaskClient, content: bytes, name: str = "scan.ply", **fields: str):
    return client.post("/api/scans", data={"file": (io.BytesIO(content), name), **fields})


@pytest.mark.slow
def test_an_upload_says_what_was_read(client: FlaskClient, torso: bytes) -> None:
    answer = upload(client, torso, "Jane Doe.ply")
    assert answer.status_code == 201
    scan = answer.json
    assert scan["unit"] == "m"
    assert scan["unit_reason"].endswith(".")
    assert scan["size_doubt"] == ""
    in_mm = upload(client, torso_ply(1000.0), units="mm").json
    assert (in_mm["unit"], in_mm["bounds_m"]["max"][1]) == ("mm", pytest.approx(0.5, abs=1e-6))
    large = upload(client, torso_ply(3.5), "scan.ply").json
    assert large["unit"] == "m"
    assert large["size_doubt"].startswith("Read in metres the body is 2.")
    assert (scan["vertices"], scan["triangles"]) == (1625, 3072)
    assert scan["body_triangles"] == 3072
    assert np.allclose(scan["bounds_m"]["min"][1], 0.0, atol=1e-6)
    assert np.allclose(scan["bounds_m"]["max"][1], 0.5, atol=1e-6)
    assert scan["colours"] == "none"
    assert np.allclose(np.linalg.norm(scan["frame"]["up"]), 1.0)
    assert np.allclose(np.dot(scan["frame"]["up"], scan["frame"]["front"]), 0.0, atol=1e-6)
    assert scan["stance"]["proposed"] in ("standing", "supine")
    assert answer.headers["Location"] == scan["links"]["self"] == f"/api/scans/{scan['id']}"
    assert len(scan["id"]) == 22
    assert client.get(scan["links"]["self"]).json == scan
    assert client.delete(scan["links"]["self"]).status_code == 204


@pytest.mark.slow
def test_no_word_and_no_name_of_an_upload_is_kept_anywhere(client: FlaskClient, service: Service) -> None:
    scans = []
    for kind in ("glb", "zip"):  # the other formats are kept in the same form: tests/scan/test_stored_scan.py
        data = NAMED[kind]()
        answer = upload(client, data, f"{NAME}.{kind.rsplit('.', 1)[-1]}")
        assert answer.status_code == 201, answer.json
        scans.append(answer.json["links"]["self"])
        place = service.storage.files.scan(answer.json["id"])
        assert {path.name for path in place.iterdir()} == {"scan.json", "scan.stored", "mesh.glb", "thumbnail.png"}
        assert get_scan(service.storage, answer.json["id"]).sha256 == hashlib.sha256(data).hexdigest()
    assert NAME.encode() not in kept_below(service.storage.root)
    assert [client.delete(scan).status_code for scan in scans] == [204] * len(scans)


def test_the_mesh_for_display_is_a_glb_that_no_browser_keeps(client: FlaskClient, scan_id: str) -> None:
    answer = client.get(f"/api/scans/{scan_id}/mesh.glb")
    assert answer.status_code == 200
    assert answer.mimetype == "model/gltf-binary"
    assert answer.data[:4] == b"glTF"
    assert answer.headers["Cache-Control"] == "no-store"
    again = client.get(f"/api/scans/{scan_id}/mesh.glb", headers={"If-None-Match": answer.headers["ETag"]})
    assert (again.status_code, again.data) == (304, b"")
    part = client.get(f"/api/scans/{scan_id}/mesh.glb", headers={"Range": "bytes=0-3"})
    assert (part.status_code, part.data) == (206, b"glTF")


def test_delete_removes_everything_and_may_be_repeated(client: FlaskClient, service: Service, torso: bytes) -> None:
    scan_id = upload(client, torso).json["id"]
    for _ in range(2):
        assert client.delete(f"/api/scans/{scan_id}").status_code == 204
    for place in ("", "/mesh.glb", "/landmarks"):
        assert "no such scan" in problem(client.get(f"/api/scans/{scan_id}{place}"), 404)
    assert not service.storage.files.scan(scan_id).exists()


BAD_FILES = {  # how each format can be broken is a question of tests/scan
    "text named .ply": (b"Dear colleague,\nplease find the scan attached.\n", "scan.ply"),
    "truncated GLB": (b"glTF" + struct.pack("<II", 2, 100000) + b"\x10\0\0\0JSON{", "scan.glb"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_a_bad_file_gives_one_sentence_and_leaves_nothing(client: FlaskClient, service: Service, case: str) -> None:
    before = set(service.storage.root.rglob("scan.json"))
    content, name = BAD_FILES[case]
    assert len(problem(upload(client, content, name), 422)) > 20
    assert set(service.storage.root.rglob("scan.json")) == before


def test_a_scan_in_the_wrong_unit_is_refused(client: FlaskClient) -> None:
    problem(upload(client, torso_ply(), units="mm"), 422)  # half a millimetre tall
    problem(upload(client, torso_ply(1000.0), units="m"), 422)  # half a kilometre tall


def test_too_many_triangles_are_refused(client: FlaskClient, service: Service, monkeypatch) -> None:
    monkeypatch.setattr(service.uploads, "_limits", replace(service.uploads._limits, triangles=1000))
    assert "3,072 triangles" in problem(upload(client, torso_ply()), 413)


NAMES = ["IM000001", "scan.ply.doc", "../../etc/passwd"]


def test_the_bytes_decide_and_no_name(client: FlaskClient, torso: bytes) -> None:
    for name in NAMES:
        assert upload(client, torso, name).status_code == 201
    sentence = "This file is no 3D scan that can be read; give PLY, OBJ, STL, GLB, glTF, USDZ, OFF, 3MF, PCD, "
    sentence += "a table of points, a label map (NIfTI, NRRD, MetaImage, DICOM SEG), or a zip of one of them."
    assert problem(upload(client, b"\x89PNG\r\n\x1a\n" + bytes(500), "IM000001"), 422) == sentence


def test_a_form_without_a_file_is_refused(client: FlaskClient) -> None:
    wanted = "file: No file was sent under this name; send it as this field of multipart/form-data."
    under_another_name = {"scan": (io.BytesIO(b"ply"), "scan.ply")}
    for form in ({"units": "mm"}, {"file": "just text"}, under_another_name):
        assert problem(client.post("/api/scans", data=form, content_type="multipart/form-data"), 422) == wanted


def test_an_unknown_unit_is_refused_with_the_known_ones(client: FlaskClient, torso: bytes) -> None:
    sentence = problem(upload(client, torso, units="furlong"), 422)
    assert sentence.startswith("units:")
    assert "'mm'" in sentence


@pytest.mark.parametrize(("unit", "factor"), [("m", 0.001), ("in", 1 / 25.4)])
def test_landmarks_in_any_unit_are_kept_in_mm(client: FlaskClient, scan_id: str, unit: str, factor: float) -> None:
    sent = {"unit": unit, "landmarks": {"nipple_L": [factor * each for each in (70.0, 350.0, 120.5)]}}
    answer = client.put(f"/api/scans/{scan_id}/landmarks", json=sent).json
    assert answer["unit"] == "mm"
    assert answer["landmarks"]["nipple_L"] == pytest.approx([70.0, 350.0, 120.5])
    assert client.put(f"/api/scans/{scan_id}/landmarks", json={**sent, "unit": "ell"}).status_code == 422


def test_all_landmarks_that_are_not_known_are_listed(client: FlaskClient, scan_id: str) -> None:
    sent = {"landmarks": {"elbow": [0, 0, 0], "Mamille": [0, 0, 0]}}
    detail = client.put(f"/api/scans/{scan_id}/landmarks", json=sent).json["detail"]
    assert detail.startswith('Not a landmark: "elbow", "Mamille"; known are: suprasternal_notch')


def test_landmarks_are_kept(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    empty = {"schema": "breastrig/landmarks@1", "unit": "mm", "landmarks": {}, "certain": []}
    assert client.get(place).json == empty
    picked = {**empty, "landmarks": {"nipple_L": [70.0, 350.0, 120.5]}}
    answer = client.put(place, json=picked)
    assert (answer.status_code, answer.json) == (200, picked)
    assert client.get(place).json == picked
    assert client.put(place, json={"landmarks": {}}).json == empty


def test_landmarks_that_cannot_be_meant_are_refused(client: FlaskClient, scan_id: str) -> None:
    for body, word in (
        ({"landmarks": {"elbow": [0, 0, 0]}}, '"elbow" is not a landmark; known are: suprasternal_notch'),
        ({"landmarks": {"nipple_L": [0, 0]}}, "landmarks.nipple_L"),
        ({"landmarks": {"nipple_L": [0, 0, 9000]}}, "nipple_L lies 8.8"),
        ({"landmark": {}}, "landmarks: Field required (1 more)"),
        ({"landmarks": {}, "certain": ["nipple_L"]}, '"certain" names nipple_L, which is not among these landmarks'),
        ("null", "valid"),
    ):
        assert word in problem(client.put(f"/api/scans/{scan_id}/landmarks", json=body), 422)


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"id,label,pos x,pos y,pos z\n1,Left Nipple,70,350,120\n", {"nipple_L": [70.0, 350.0, 120.0]}),
        (b'{"landmarks": {"nipple_L": [70, 350, 120]}, "unit": "mm", "certain": ["nipple_L"]}', {
            "nipple_L": [70.0, 350.0, 120.0]
        }),
        (b'{"landmarks": {"nose": [70, 350, 120]}}', '"nose" is not a landmark; known are: suprasternal_notch'),
        (b"nipple_L,70,350,9000", "nipple_L lies 9,000 m outside"),
    ],
)  # fmt: skip
def test_a_file_of_landmarks_is_read_as_the_command_line_reads_it(
    client: FlaskClient, scan_id: str, content: bytes, found: dict[str, list[float]] | str
) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    kept = client.get(place).json
    answer = client.post(f"{place}/file", data={"file": (io.BytesIO(content), "picks.csv")})
    if isinstance(found, str):
        assert found in problem(answer, 422)
        return
    assert answer.status_code == 200, answer.json
    assert answer.json["unit"] == "mm"
    assert {name: pytest.approx(point) for name, point in answer.json["landmarks"].items()} == found
    assert answer.json["certain"] == (["nipple_L"] if b"certain" in content else [])
    assert client.get(place).json == kept


def test_landmarks_are_written_in_the_kinds_that_are_read(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    kept = client.get(place).json
    given = {"landmarks": {"nipple_L": [70.0, 350.0, 120.5]}, "unit": "mm", "certain": ["nipple_L"]}
    for kind in ("json", "csv", "pp", "mrk.json"):
        written = client.post(f"{place}/file/{kind}", json=given)
        assert written.headers["Cache-Control"] == "no-store"
        again = client.post(f"{place}/file", data={"file": (io.BytesIO(written.data), f"picks.{kind}")}).json
        assert again["landmarks"]["nipple_L"] == pytest.approx([70.0, 350.0, 120.5])
        assert again["certain"] == (["nipple_L"] if kind == "json" else [])
    problem(client.post(f"{place}/file/doc", json=given), 422)
    assert client.get(place).json == kept


def test_what_a_person_is_certain_of_is_kept_with_the_landmarks(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    picked = {"nipple_L": [70.0, 350.0, 120.5], "nipple_R": [-70.0, 350.0, 120.5]}
    assert client.put(place, json={"landmarks": picked, "certain": ["nipple_R"]}).status_code == 200
    assert client.get(place).json["certain"] == ["nipple_R"]
    client.put(place, json={"landmarks": picked})
    assert client.get(place).json["certain"] == []


def test_what_was_only_agreed_to_is_kept_with_the_landmarks(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    proposed = client.get(f"{place}/proposed").json["landmarks"]["nipple_L"]
    picked = {"nipple_L": proposed["point"], "nipple_R": [-70.0, 350.0, 120.5]}
    agreed = client.put(place, json={"landmarks": picked})
    assert agreed.json["confidence"] == {"nipple_L": proposed["confidence"]}
    assert client.get(place).json == agreed.json
    looked_at = client.put(place, json={"landmarks": picked, "confidence": {"nipple_L": 1.0}})
    assert client.get(place).json["confidence"] == {"nipple_L": 1.0}
    assert looked_at.headers["ETag"] != agreed.headers["ETag"]
    unsure = {"landmarks": picked, "certain": ["nipple_R"], "confidence": {"nipple_R": 0.5}}
    assert "nipple_R is proposed and cannot be certain" in problem(client.put(place, json=unsure), 422)


def test_who_says_which_landmarks_were_seen_replaces_no_others(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    left, right = {"nipple_L": [70.0, 350.0, 120.0]}, {"nipple_R": [-70.0, 350.0, 120.0]}
    nothing = client.get(place).headers["ETag"]
    assert nothing == '""'
    first = client.put(place, json={"landmarks": left}, headers={"If-Match": nothing})
    assert first.status_code == 200, first.json
    assert client.get(place).headers["ETag"] == first.headers["ETag"]
    late = client.put(place, json={"landmarks": right}, headers={"If-Match": nothing})
    assert problem(late, 412).startswith("Somebody has changed these landmarks since you read them; read them again")
    assert late.headers["ETag"] == first.headers["ETag"]
    assert client.get(place).json["landmarks"] == left
    tag = {"If-Match": f"W/{first.headers['ETag']}"}  # as a proxy that compresses makes of it
    both = client.put(place, json={"landmarks": right | left, "certain": ["nipple_L"]}, headers=tag)
    assert both.status_code == 200
    assert client.get(place).json["landmarks"] == left | right
    less = client.put(place, json={"landmarks": right | left}, headers=tag)
    assert less.status_code == 412, "certainty counts as well"
    assert client.put(place, json={"landmarks": right}).status_code == 200, "a script that names none replaces any"


def test_landmarks_that_are_not_finite_are_refused(client: FlaskClient, scan_id: str) -> None:
    body = json.dumps({"landmarks": {"nipple_L": [0, 0, float("nan")]}})
    answer = client.put(f"/api/scans/{scan_id}/landmarks", data=body, content_type="application/json")
    assert "finite" in problem(answer, 422)


def test_landmarks_are_proposed_and_not_stored_as_picked(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    answers = [client.get(client.get(f"/api/scans/{scan_id}").json["links"]["proposed"]) for _ in range(2)]
    assert [answer.status_code for answer in answers] == [200, 200]
    assert answers[0].json == {
        "unit": "mm",
        "landmarks": {
            "nipple_L": {
                "point": [70.0, 350.0, 120.0],
                "confidence": 0.5,
                "on_scan": True,
                "error_mm": 16.0,
                "reason": "areola seen",
            }
        },
        "not_proposed": {"umbilicus": "The scan shows no skin where it is expected."},
    }
    assert answers[1].json == answers[0].json
    assert client.get(place).json["landmarks"] == {}


def test_proposals_that_take_long_are_asked_for_again(
    client_for, service: Service, config: Config, scan_id: str
) -> None:
    held = service.storage.files.scan(scan_id) / "held"
    held.touch()
    hasty = client_for(replace(config, proposal_wait_s=0.0))
    place = f"/api/scans/{scan_id}/landmarks/proposed"
    answer = hasty.get(place)
    assert (answer.status_code, answer.data, answer.headers["Retry-After"]) == (202, b"", "1")
    held.unlink()
    until(lambda: hasty.get(place).status_code == 200, "the proposals")


def test_unknown_scans_are_not_found(client: FlaskClient) -> None:
    for method, place in (("get", ""), ("get", "/mesh.glb"), ("get", "/landmarks"), ("get", "/landmarks/proposed")):
        problem(getattr(client, method)(f"/api/scans/nobody{place}"), 404)
    problem(client.put("/api/scans/nobody/landmarks", json={"landmarks": {}}), 404)


def test_the_example_opens_like_an_upload(client: FlaskClient) -> None:
    assert client.get("/api/examples").json == {
        "examples": [{"name": "standing", "label": "Example patient, standing", "stance": "standing"}]
    }
    answer = client.post("/api/examples/standing")
    assert answer.status_code == 201
    assert answer.json["example_landmarks"]["landmarks"] == {"nipple_L": [70.0, 350.0, 120.0]}
    assert client.get(answer.json["links"]["landmarks"]).json["landmarks"] == {}
    assert client.get(answer.json["links"]["mesh"]).data[:4] == b"glTF"
    assert '"lying" is not a example' in problem(client.post("/api/examples/lying"), 404)
