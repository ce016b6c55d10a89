"""Ink on a scan: looked for once, kept with the scan, deleted with it."""

import io

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.inked_scan import inked_zip
from helpers.waiting import until

from breastrig.cases.of_scans import get_ink, put_ink
from breastrig.service.scans import scan_search as ink_search
from breastrig.service.service import Service


@pytest.fixture
def inked(client: FlaskClient) -> str:
    answer = client.post("/api/scans", data={"file": (io.BytesIO(inked_zip()), "scan.zip"), "units": "m"})
    assert answer.status_code == 201, answer.json
    assert answer.json["colours"] == "texture"
    return answer.json["id"]


@pytest.mark.slow
def test_ink_is_found_once_and_deleted_with_the_scan(
    client: FlaskClient, service: Service, inked: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = client.get(f"/api/scans/{inked}").json["links"]["ink"]
    assert place == f"/api/scans/{inked}/ink"
    until(lambda: client.get(place).status_code == 200, "the ink")
    found = client.get(place).json
    assert (found["schema"], found["unit"]) == ("breastrig/drawing@1", "mm")
    assert {shape["kind"] for shape in found["shapes"]} == {"line", "closed", "dashed", "cross", "writing"}
    assert all(shape["length_mm"] > 10 for shape in found["shapes"])
    until(lambda: get_ink(service.storage.case_of_scan(inked), inked) is not None, "the row")

    def again(_job: object) -> None:
        raise AssertionError("it was kept")

    monkeypatch.setattr(ink_search, "find_ink_on_file", again)
    assert client.get(place).json == found
    assert client.delete(f"/api/scans/{inked}").status_code == 204
    assert client.get(place).status_code == 404
    assert not [file for file in service.storage.root.rglob("ink.json") if inked in str(file)]


def test_what_a_person_dropped_stays_dropped_until_it_is_taken_back(
    client: FlaskClient, service: Service, inked: str
) -> None:
    place = f"/api/scans/{inked}/ink"
    answer = client.patch(place, json={"dropped": {"ink_1": True}})
    assert answer.status_code == 409
    assert answer.json["detail"].startswith("The ink of this scan has not been looked for yet")
    until(lambda: client.get(place).status_code == 200, "the ink")
    until(lambda: get_ink(service.storage.case_of_scan(inked), inked) is not None, "the row")
    found = client.get(place).json
    names = [shape["name"] for shape in found["shapes"]]
    assert not any(shape["dropped"] for shape in found["shapes"])

    def dropped() -> list[str]:
        shapes = client.get(place).json["shapes"]
        assert [shape | {"dropped": False} for shape in shapes] == found["shapes"]
        return [shape["name"] for shape in shapes if shape["dropped"]]

    answer = client.patch(place, json={"dropped": {names[0]: True, names[2]: True}})
    assert answer.status_code == 200
    assert answer.json == client.get(place).json
    assert dropped() == [names[0], names[2]]
    assert client.patch(place, json={"dropped": {names[0]: False, names[1]: True}}).status_code == 200
    assert dropped() == [names[1], names[2]]
    put_ink(service.storage.case_of_scan(inked), inked, found)  # found once more by another process
    assert dropped() == [names[1], names[2]]

    answer = client.patch(place, json={"dropped": {names[1]: False, "midline": True}})
    assert answer.status_code == 422
    assert answer.json["detail"].startswith('No line called "midline" was found on this scan')
    assert dropped() == [names[1], names[2]]
    assert client.patch(place, json={"dropped": {names[1]: "perhaps"}}).status_code == 422
    assert client.delete(f"/api/scans/{inked}").status_code == 204
    assert client.patch(place, json={"dropped": {names[1]: True}}).status_code == 404
    assert not [file for file in service.storage.root.rglob("ink.json") if inked in str(file)]


def test_a_scan_without_colour_is_one_sentence(client: FlaskClient, scan_id: str) -> None:
    answer = client.get(f"/api/scans/{scan_id}/ink")
    assert answer.status_code == 422
    assert answer.json["detail"].startswith("This scan has no colour")
    assert client.get("/api/scans/nothing/ink").status_code == 404


def test_lines_in_what_was_cut_away_say_so_until_the_cut_is_taken_back(client: FlaskClient, inked: str) -> None:
    place = f"/api/scans/{inked}/ink"
    until(lambda: client.get(place).status_code == 200, "the ink")
    found = client.get(place).json["shapes"]
    assert not any(shape["cut"] for shape in found)
    shares = [np.mean(np.array(shape["points"])[:, 0] > 0.0) for shape in found]
    right = [share > 0.5 for share in shares]
    assert any(right)
    assert not all(right)
    lasso = [[0.0, -9.0], [9.0, -9.0], [9.0, 9.0], [0.0, 9.0]]  # all that lies to the right of x = 0
    cut = {"to_picture": np.eye(4).ravel().tolist(), "lasso": lasso}
    assert client.put(f"/api/scans/{inked}/cuts", json={"cuts": [cut]}).status_code == 200
    now = client.get(place).json["shapes"]
    assert [shape["cut"] for shape in now] == right
    assert [shape | {"cut": False} for shape in now] == found
    name = found[right.index(True)]["name"]
    answer = client.patch(place, json={"dropped": {name: True}}).json["shapes"]
    assert next((shape["name"], shape["dropped"]) for shape in answer if shape["cut"]) == (name, True)
    assert client.put(f"/api/scans/{inked}/cuts", json={"cuts": []}).status_code == 200
    assert not any(shape["cut"] for shape in client.get(place).json["shapes"])
