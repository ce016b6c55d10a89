"""Marks with the landmarks of a scan: kept, given to fits, gone with the scan."""

import io

import pytest
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem
from helpers.waiting import ended

from breastrig.service.service import Service

pytestmark = pytest.mark.long

LANDMARKS = {"nipple_L": [70.0, 350.0, 120.0]}
MARKS = {"mole under the left breast": [60.0, 300.0, 110.0]}


def test_marks_are_kept_until_they_are_replaced(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks"
    centimetres = {name: [0.1 * value for value in point] for name, point in MARKS.items()}
    answer = client.put(place, json={"landmarks": {}, "unit": "cm", "marks": centimetres})
    assert answer.json["marks"] == {name: pytest.approx(point) for name, point in MARKS.items()}
    kept = client.get(place)
    assert kept.json == answer.json
    without = client.put(place, json={"landmarks": LANDMARKS}, headers={"If-Match": kept.headers["ETag"]})
    assert without.json["marks"] == kept.json["marks"]  # a page that knows no marks drops none
    assert client.put(place, json={"landmarks": {}}, headers={"If-Match": kept.headers["ETag"]}).status_code == 412
    assert "marks" not in client.put(place, json={"landmarks": LANDMARKS, "marks": {}}).json


@pytest.mark.parametrize(
    ("marks", "says"),
    [
        ({"nipple_Left": [70.0, 350.0, 120.0]}, 'Is "nipple_Left" the landmark nipple_L?'),
        ({"mole": [0.0, 0.0, 9000.0]}, "mole lies 8.8"),
        ({"a\nb": [70.0, 350.0, 120.0]}, "has no proper name"),
        ({"mole": [70.0, 350.0]}, "marks.mole"),
    ],
)
def test_marks_that_cannot_be_meant_are_refused(client: FlaskClient, scan_id: str, marks: object, says: str) -> None:
    asked = {"landmarks": {}, "marks": marks}
    assert says in problem(client.put(f"/api/scans/{scan_id}/landmarks", json=asked), 422)
    assert says in problem(client.post("/api/fits", json={"scan": scan_id, **asked}), 422)


def test_names_in_a_table_that_no_landmark_has_are_marks(client: FlaskClient, scan_id: str) -> None:
    place = f"/api/scans/{scan_id}/landmarks/file"
    for kind in ("json", "csv", "pp", "mrk.json"):
        written = client.post(f"{place}/{kind}", json={"landmarks": LANDMARKS, "marks": MARKS}).data
        again = client.post(place, data={"file": (io.BytesIO(written), f"picks.{kind}")}).json
        assert {name: pytest.approx(point) for name, point in again["marks"].items()} == MARKS
        assert list(again["landmarks"]) == ["nipple_L"]


def test_fits_have_the_marks_of_the_scan_unless_they_are_given(
    client: FlaskClient, service: Service, scan_id: str
) -> None:
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": LANDMARKS, "marks": MARKS})
    own = {"dot": [1.0, 300.0, 100.0]}
    for body, expected in (({}, MARKS), ({"landmarks": {}}, MARKS), ({"marks": own}, own), ({"marks": {}}, {})):
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, **body})
        ended(service, answer.json["id"])
        assert client.get(answer.json["links"]["result"]).json["marks_given"] == expected
        assert client.get(answer.json["links"]["self"]).json.get("marks", {}) == expected


def test_marks_go_with_their_scan(client: FlaskClient, service: Service, scan_id: str) -> None:
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": {}, "marks": {"xyzzymole": [60.0, 300.0, 110.0]}})
    assert b"xyzzymole" in bytes_below(service.storage.root)
    client.delete(f"/api/scans/{scan_id}")
    assert b"xyzzymole" not in bytes_below(service.storage.root)
