"""Marks with the landmarks of a scan: kept, given to fits, gone with the scan."""

import io
from collections.abc import Iterator

import pytest
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

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


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[FlaskClient, dict[str, dict[str, str]]]]:
    """The example patient in both stances, of one case, with the nipples as marks, one of them 40 mm off lying."""
    service = Service(
        Storage(tmp_path_factory.mktemp("marks")), runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1)
    )
    with service.started():
        client = create_app(Config(), service).test_client()
        ids: dict[str, dict[str, str]] = {}
        for stance in ("standing", "supine"):
            scan = client.post(f"/api/examples/{stance}").json
            places = scan["example_landmarks"]["landmarks"]
            marks = {"dot": places.pop("nipple_L"), "mole": places.pop("nipple_R"), stance: places["xiphoid"]}
            if stance == "supine":
                marks["mole"] = places["xiphoid"]
            kept = {"landmarks": places, "marks": marks}
            assert client.put(f"/api/scans/{scan['id']}/landmarks", json=kept).status_code == 200
            fit = client.post("/api/fits", json={"scan": scan["id"], "drawing": "lumpectomy"}).json["id"]
            assert ended(service, fit).state == "done"
            ids[stance] = {"scan": scan["id"], "fit": fit}
        patient = client.get(f"/api/scans/{ids['standing']['scan']}").json["patient"]
        hers = {"patient": patient, "same_as": [ids["standing"]["scan"]]}
        assert client.put(f"/api/scans/{ids['supine']['scan']}/patient", json=hers).status_code == 200
        yield client, ids


@pytest.mark.slow
def test_lines_between_two_fits_follow_their_marks(real: tuple[FlaskClient, dict[str, dict[str, str]]]) -> None:
    client, ids = real
    fits = {"from_fit": ids["standing"]["fit"], "to_fit": ids["supine"]["fit"]}
    answer = client.post("/api/transfers", json=fits | {"same_patient": True})
    assert answer.status_code == 201, answer.json
    marks = answer.json["marks"]
    assert (marks["followed"], marks["unpaired"]) == (["dot"], ["standing", "supine"])
    assert [each["name"] for each in marks["asked"]] == ["mole"]
    other = client.post("/api/transfers", json=fits | {"other_patient": True})
    assert "marks" not in other.json


@pytest.mark.slow
def test_the_plan_of_a_patient_follows_marks_and_a_link_names_none(
    real: tuple[FlaskClient, dict[str, dict[str, str]]],
) -> None:
    client, ids = real
    standing, supine = ids["standing"], ids["supine"]
    patient = client.get(f"/api/scans/{standing['scan']}").json["patient"]
    tumour = {"kind": "tumour", "id": "t", "scan": standing["scan"], "side": "L", "clock": 3, "distance_mm": 30}
    plan = {"schema": "breastrig/plan@1", "items": [tumour | {"radius_mm": 10}]}
    first = {"If-Match": '"0"'}
    assert client.put(f"/api/patients/{patient}/plan", json=plan, headers=first).status_code == 200
    shown = client.get(f"/api/fits/{supine['fit']}/plan.json").json
    assert shown["missing"] == []
    [marks] = shown["marks"]
    assert (marks["scan"], marks["followed"]) == (standing["scan"], ["dot"])
    assert [each["name"] for each in marks["asked"]] == ["mole"]
    made, visitor = client.post(f"/api/fits/{supine['fit']}/shares", json={}).json, client.application.test_client()
    assert visitor.post("/api/shared/open", json={"token": made["url"].partition("#")[2]}).status_code == 200
    with visitor.get(f"/api/shared/{made['id']}/plan.json") as linked:
        assert linked.status_code == 200
        assert "mole" not in linked.get_data(as_text=True)


@pytest.mark.slow
def test_marks_by_colour_need_fine_colours_and_two_fits_that_are_done(
    real: tuple[FlaskClient, dict[str, dict[str, str]]],
) -> None:
    client, ids = real
    fits = {"from_fit": ids["standing"]["fit"], "to_fit": ids["supine"]["fit"], "same_patient": True}
    assert "too coarse for lines of a pen" in problem(client.post("/api/transfers/marks", json=fits), 422)
    assert "There is no such fit" in problem(client.post("/api/transfers/marks", json=fits | {"to_fit": "0" * 32}), 404)
