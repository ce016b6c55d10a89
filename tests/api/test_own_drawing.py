"""The surgeon's own drawing on a scan: what is kept, what is refused, and that it goes with the scan."""

import io
import json
from collections.abc import Iterator

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem

from breastrig.scan.read import read_scan
from breastrig.service.service import Service

LINE = {
    "name": "incision",
    "label": "",
    "closed": False,
    "color": "#b83280",
    "points": [[70.0, 350.0, 120.0], [60.5, 340.25, 121.0]],
}
DRAWING = {"schema": "breastrig/drawing@1", "unit": "mm", "shapes": [LINE]}


@pytest.fixture(scope="module")
def shared_scan(app: APIFlask, torso: bytes) -> Iterator[str]:
    """A scan for the tests that leave no drawing on it."""
    client = app.test_client()
    scan_id = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
    yield scan_id
    client.delete(f"/api/scans/{scan_id}")


def place(scan_id: str) -> str:
    return f"/api/scans/{scan_id}/drawing"


def test_a_drawing_is_kept_with_its_scan(client: FlaskClient, scan_id: str) -> None:
    assert client.get(f"/api/scans/{scan_id}").json["links"]["drawing"] == place(scan_id)
    assert client.get(place(scan_id)).json == DRAWING | {"shapes": []}
    answer = client.put(place(scan_id), json=DRAWING)
    assert (answer.status_code, answer.json) == (200, DRAWING)
    assert client.get(place(scan_id)).json == DRAWING
    assert client.get(place(scan_id)).headers["Cache-Control"] == "no-store"
    empty = DRAWING | {"shapes": []}
    assert client.put(place(scan_id), json=empty).json == empty
    assert client.get(place(scan_id)).json == empty


def test_points_up_to_10_mm_off_the_skin_are_taken(client: FlaskClient, scan_id: str, torso: bytes) -> None:
    vertices = read_scan(torso, "ply").vertices
    front = 1e3 * vertices[vertices[:, 2].argmax()]
    for gap_mm, status in ((9.0, 200), (11.0, 422)):
        answer = client.put(place(scan_id), json=line(points=[[*front], [*front[:2], front[2] + gap_mm]]))
        assert answer.status_code == status
    assert problem(answer, 422).startswith('Point 2 of "incision" is 11 mm away from the scan; draw on the skin')
    guessed = line(points=[[*front], [*front[:2], front[2] + 30.0]], bridged=[False, True])
    assert client.put(place(scan_id), json=guessed).status_code == 200


def test_a_drawing_file_of_a_transfer_can_be_kept_as_it_is(client: FlaskClient, scan_id: str) -> None:
    """What is not part of the drawing is passed over, and nothing of it is stored."""
    bridged = LINE | {"bridged": [False, True]}
    carried = DRAWING | {"name": "x", "notice": "n", "shapes": [bridged | {"patient": "Ada"}]}
    assert client.put(place(scan_id), json=carried).json == DRAWING | {"shapes": [bridged]}
    assert client.get(place(scan_id)).json == DRAWING | {"shapes": [bridged]}


def line(**changes: object) -> dict[str, object]:
    return DRAWING | {"shapes": [LINE | changes]}


def test_a_drawing_that_is_not_on_this_scan_is_refused(client: FlaskClient, shared_scan: str) -> None:
    """What can be no drawing at all: test_drawing_limits."""
    for body, word in (
        (line(points=[[70.0, 350.0, 900.0]]), '"incision" lies 0.7'),
        (line(points=[[0.07, 0.35, 0.12], [7e4, 0.0, 0.0]]), "outside of the scan; drawings are millimetres"),
        (DRAWING | {"unit": "m"}, "unit"),
        ({}, "shapes: Field required"),
    ):
        assert word in problem(client.put(place(shared_scan), json=body), 422)
    assert client.get(place(shared_scan)).json == DRAWING | {"shapes": []}
    body = json.dumps(DRAWING).replace("340.25", "1e999")
    answer = client.put(place(shared_scan), data=body, content_type="application/json")
    assert "finite" in problem(answer, 422)


def test_too_much_is_refused_with_what_may_be(client: FlaskClient, shared_scan: str) -> None:
    whole = client.put(place(shared_scan), data=b" " * 20_000_001, content_type="application/json")
    assert "20 MB" in problem(whole, 413)


def test_unknown_scans_have_no_drawing(client: FlaskClient) -> None:
    problem(client.get(place("nobody")), 404)
    problem(client.put(place("nobody"), json=DRAWING), 404)


def test_deleting_the_scan_leaves_nothing_of_the_drawing(client: FlaskClient, service: Service, torso: bytes) -> None:
    scan_id = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
    secret = "left_of_the_mole_near_the_rib"
    assert client.put(place(scan_id), json=line(name=secret)).status_code == 200
    assert secret.encode() in bytes_below(service.storage.root)
    assert client.delete(f"/api/scans/{scan_id}").status_code == 204
    assert secret.encode() not in bytes_below(service.storage.root)
    problem(client.get(place(scan_id)), 404)
