"""A length that was measured on the patient gives a scan its true size, in all that is asked for and answered."""

import json
from io import BytesIO

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.waiting import ended, until

from breastrig.core.glb import split_glb
from breastrig.scan.unscaled import UNKNOWN_SIZE
from breastrig.service.service import Service

PICKS = {"nipple_L": [70.0, 350.0, 120.0], "nipple_R": [-70.0, 350.0, 120.0]}
NAMES = {"from": "nipple_L", "to": "dot"}
DOT = [70.0, 350.0, 20.0]  # 100 mm from the nipple
FACTOR = 1.031


@pytest.fixture
def place(client: FlaskClient, scan_id: str) -> str:
    """Of the length of a scan with landmarks and a mark."""
    picks = {"landmarks": PICKS, "marks": {"dot": DOT}}
    assert client.put(f"/api/scans/{scan_id}/landmarks", json=picks).status_code == 200
    return f"/api/scans/{scan_id}/length"


def times(points: dict[str, list[float]], factor: float) -> dict[str, object]:
    return {name: pytest.approx([factor * value for value in at]) for name, at in points.items()}


def test_the_scan_and_what_is_kept_of_it_is_in_the_true_size_until_the_length_goes(
    client: FlaskClient, scan_id: str, place: str
) -> None:
    scan, landmarks, mesh = f"/api/scans/{scan_id}", f"/api/scans/{scan_id}/landmarks", f"/api/scans/{scan_id}/mesh.glb"
    before, picks, plain = client.get(scan).json, client.get(landmarks), client.get(mesh)
    assert "scale" not in before
    found = client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR}).json
    assert found == client.get(scan).json
    assert found["scale"]["factor"] == pytest.approx(FACTOR)
    assert found["scale"]["between"] == ["nipple_L", "dot"]
    assert found["scale"]["ends"][1] == pytest.approx([FACTOR * value for value in DOT])
    for name in ("min", "max"):
        assert found["bounds_m"][name] == pytest.approx([FACTOR * value for value in before["bounds_m"][name]])
    assert found["size_m"] == pytest.approx([FACTOR * value for value in before["size_m"]])
    assert (found["size_doubt"], found["unit"]) == ("", before["unit"])
    assert found["notes"][-1].startswith("Scaled by 1.031: 103.1 mm from nipple_L to dot, 100.0 mm in the file.")
    scaled = client.get(mesh)
    [node] = split_glb(scaled.data)[0]["nodes"]
    assert (node["scale"], scaled.headers["ETag"] == plain.headers["ETag"]) == ([pytest.approx(FACTOR)] * 3, False)
    shown = client.get(landmarks)
    assert shown.json["landmarks"] == times(PICKS, FACTOR)
    assert shown.json["marks"] == times({"dot": DOT}, FACTOR)
    late = client.put(landmarks, json={"landmarks": PICKS}, headers={"If-Match": picks.headers["ETag"]})
    assert late.status_code == 412  # they were seen in the other size
    assert client.delete(place).json == before
    assert client.get(landmarks).json == picks.json
    assert client.get(mesh).data == plain.data


def test_landmarks_say_in_which_size_they_are_and_are_taken_from_any(
    client: FlaskClient, scan_id: str, place: str
) -> None:
    landmarks = f"/api/scans/{scan_id}/landmarks"
    of_file = client.get(landmarks).json
    assert "scale" not in of_file
    client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR})
    shown = client.get(landmarks).json
    assert shown["scale"] == pytest.approx(FACTOR)
    for given in ({"landmarks": PICKS, "marks": {"dot": DOT}, "scale": 1}, shown, of_file | {"scale": 1.0}):
        client.put(landmarks, json={"landmarks": {}, "marks": {}})
        assert client.put(landmarks, json=given).json == client.get(landmarks).json
        assert client.get(landmarks).json["landmarks"] == times(PICKS, FACTOR)
        assert client.get(landmarks).json["marks"] == times({"dot": DOT}, FACTOR)
    marks_stay = client.put(landmarks, json={"landmarks": PICKS, "scale": 1.0}).json
    assert marks_stay["marks"] == times({"dot": DOT}, FACTOR)
    written = json.loads(client.post(f"{landmarks}/file/json", json=client.get(landmarks).json).data)
    assert written["scale"] == shown["scale"]
    for scale, factor in (({}, 1.0), ({"scale": 1.0}, FACTOR), ({"scale": FACTOR}, 1.0)):
        document = {"schema": "breastrig/landmarks@1", "landmarks": PICKS, "unit": "mm"} | scale
        file = (BytesIO(json.dumps(document).encode()), "picks.json")
        read = client.post(f"{landmarks}/file", data={"file": file}).json
        assert (read["landmarks"], read["scale"]) == (times(PICKS, factor), shown["scale"])
    for scale in (0.0, 30.0, True, "1"):
        problem(client.put(landmarks, json={"landmarks": PICKS, "scale": scale}), 422)
    client.delete(place)
    again = client.put(landmarks, json=shown).json
    assert "scale" not in again
    assert (again["landmarks"], again["marks"]) == (times(PICKS, 1.0), times({"dot": DOT}, 1.0))


def test_a_plan_says_in_which_size_it_is_and_is_taken_from_any(client: FlaskClient, scan_id: str, place: str) -> None:
    plan = f"/api/patients/{client.get(f'/api/scans/{scan_id}').json['patient']}/plan"
    lesion = {"kind": "lesion", "id": "l", "scan": scan_id, "name": "l", "center": PICKS["nipple_L"], "radius_mm": 5.0}

    def put(center: list[float], **scan: object) -> list[float]:
        document = {
            "schema": "breastrig/plan@1",
            "scans": [{"id": scan_id} | scan],
            "items": [lesion | {"center": center}],
        }
        kept = client.put(plan, json=document, headers={"If-Match": client.get(plan).headers["ETag"]})
        assert kept.status_code == 200, kept.json
        return list(kept.json["items"][0]["center"])

    client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR})
    true = [FACTOR * value for value in PICKS["nipple_L"]]
    assert put(PICKS["nipple_L"], scale=1.0) == pytest.approx(true)
    [said] = client.get(plan).json["scans"]
    assert said["scale"] == pytest.approx(FACTOR)
    assert put(true) == put(true, scale=said["scale"]) == pytest.approx(true)
    client.delete(place)
    assert "scale" not in client.get(plan).json["scans"][0]
    assert put(true, scale=said["scale"]) == pytest.approx(PICKS["nipple_L"])


def test_two_places_and_a_number_are_enough(client: FlaskClient, scan_id: str) -> None:
    place, ends = f"/api/scans/{scan_id}/length", {"from": PICKS["nipple_L"], "to": PICKS["nipple_R"]}
    found = client.put(place, json=ends | {"length_mm": 147.0}).json["scale"]
    assert (found["factor"], found["between"]) == (pytest.approx(1.05), ["one place", "another"])
    again = dict(zip(("from", "to"), found["ends"], strict=True))  # in the present size
    found = client.put(place, json=again | {"length_mm": 140.0}).json["scale"]
    assert (found["factor"], found["measured_mm"]) == (pytest.approx(1.0), pytest.approx(140.0))


def test_a_scan_of_unknown_size_asks_for_a_length_until_it_has_one(client: FlaskClient, torso: bytes) -> None:
    before, begins, rest = torso.partition(b"element vertex")
    file = before + b"comment Created with AliceVision\n" + begins + rest
    scan = client.post("/api/scans", data={"file": (BytesIO(file), "torso.ply")}).json
    assert (scan["size_known"], scan["notes"]) == (False, [UNKNOWN_SIZE])
    length = {"from": PICKS["nipple_L"], "to": PICKS["nipple_R"], "length_mm": 147.0}
    found = client.put(f"{scan['links']['self']}/length", json=length).json
    assert found["size_known"]
    assert UNKNOWN_SIZE not in found["notes"]
    assert not client.delete(f"{scan['links']['self']}/length").json["size_known"]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"length_mm": 10.31},
            "From nipple_L to dot it is 100 mm in the scan, but 10.31 mm were given",
        ),
        ({"to": "nose"}, 'The length ends at "nose", no landmark or mark of this scan; there are: nipple_L,'),
        ({"to": [0.0, 0.0, 9000.0]}, "An end of the length lies outside of the scan"),
        ({"to": "nipple_L"}, "both are nipple_L"),
        ({"length_mm": 0.0}, "length_mm"),
        ({"length_mm": True}, "length_mm"),
        ({"length_mm": "103"}, "length_mm"),
        ({"to": [0.0, 0.0, True]}, "to"),
        ({"to": [0.0, 0.0]}, "to"),
    ],
)
def test_a_length_that_cannot_be_meant_is_refused(
    client: FlaskClient, scan_id: str, place: str, changes: dict[str, object], says: str
) -> None:
    assert says in problem(client.put(place, json=NAMES | {"length_mm": 103.1} | changes), 422)
    assert "scale" not in client.get(f"/api/scans/{scan_id}").json


def test_fits_are_in_the_size_and_those_of_another_do_not_count(
    client: FlaskClient, service: Service, scan_id: str, place: str
) -> None:
    def fitted() -> str:
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None})
        ended(service, answer.json["id"])
        return str(answer.json["links"]["self"])

    def state(fit: str) -> str:
        return str(client.get(fit).json["state"])

    of_file = fitted()
    client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR})
    assert state(of_file) == "cancelled"
    assert "got another size after this fit was asked for" in client.get(of_file).json["reason"]
    assert problem(client.get(f"{of_file}/plan.json"), 409)
    true = fitted()
    assert state(true) == "done"
    assert client.get(true).json["landmarks"] == times(PICKS, FACTOR)
    client.delete(place)
    assert [state(of_file), state(true)] == ["done", "cancelled"]


def test_proposals_are_looked_for_in_the_size(client: FlaskClient, service: Service, scan_id: str, place: str) -> None:
    proposed = f"/api/scans/{scan_id}/landmarks/proposed"
    made = service.storage.files.scan(scan_id) / "proposed"
    for count in (1, 2):
        until(lambda: client.get(proposed).status_code == 200, "the proposals")
        assert len(made.read_text().splitlines()) == count  # looked for again in the other size
        client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR})


@pytest.mark.slow
def test_the_page_for_taking_scans_is_there_to_print(client: FlaskClient) -> None:
    answer = client.get("/api/scan_protocol.pdf")
    assert (answer.status_code, answer.mimetype, answer.data[:5]) == (200, "application/pdf", b"%PDF-")


def test_a_length_goes_with_its_scan(client: FlaskClient, service: Service, scan_id: str, place: str) -> None:
    client.put(place, json=NAMES | {"length_mm": 100.0 * FACTOR})
    [kept] = service.storage.root.rglob("length.json")
    assert scan_id in str(kept)
    client.delete(f"/api/scans/{scan_id}")
    assert not kept.exists()
    assert client.put(place, json=NAMES | {"length_mm": 103.1}).status_code == 404
    assert client.delete(place).status_code == 404
