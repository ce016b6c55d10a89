"""Drawings carried between two fits of the service: the real work on the example patient, and what is refused."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.drawing_file import parsed_drawing, shape_document
from breastrig.drawings.drawing_schema import DrawnShape
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.workflow.fit_folder import read_fit_folder
from breastrig.workflow.report import stance_of

CARRIED_FIELDS = ["name", "closed", "color", "points", "bridged", "error_mm", "distance_from_mm", "distance_to_mm"]


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient, dict[str, str]]]:
    """A service with the fits of the example patient standing and lying."""
    service = Service(Storage(tmp_path_factory.mktemp("transfers")), fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        client = create_app(Config(), service).test_client()
        fits = {}
        for name in ("standing", "supine"):
            scan = client.post(f"/api/examples/{name}").json
            picked = scan["example_landmarks"]["landmarks"]
            fits[name] = client.post("/api/fits", json={"scan": scan["id"], "landmarks": picked}).json["id"]
            assert ended(service, fits[name]).state == "done"
        yield service, client, fits


@pytest.mark.parametrize("other_patient", [False, True])
def test_the_fits_own_drawing_is_shown_on_the_other_scan(
    other_patient: bool, real: tuple[Service, FlaskClient, dict[str, str]]
) -> None:
    service, client, fits = real
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"], "other_patient": other_patient}
    answer = client.post("/api/transfers", json=wish)
    assert answer.status_code == 201, answer.json
    drawing = answer.json
    assert drawing["carried_by"] == ("model" if other_patient else "skin")
    assert {shape["name"] for shape in drawing["shapes"]} == {"sternum_upper", "sternum_lower", "breast_L", "breast_R"}
    goal = read_fit_folder(service.storage.folders.fit(fits["supine"]))
    assert drawing["unit"] == goal.unit
    target = ScanTarget(goal.surface.vertices, goal.surface.faces)
    for shape in drawing["shapes"]:
        points, bridged = goal.metres_per_unit * np.array(shape["points"]), np.array(shape["bridged"])
        assert bridged.mean() < 0.3
        assert target.search.query(points[~bridged]).distances.max() < 0.3e-3
        for key in ("distance_from_mm", "distance_to_mm"):
            known = [gap for gap in shape[key] if gap is not None]
            assert len(shape[key]) == len(points)
            assert np.mean(known) < 5.0
        assert [gap is None for gap in shape["distance_to_mm"]] == shape["bridged"]


def test_a_drawing_of_the_caller_comes_back_in_the_other_scans_unit(
    real: tuple[Service, FlaskClient, dict[str, str]],
) -> None:
    service, client, fits = real
    nipple = read_fit_folder(service.storage.folders.fit(fits["standing"])).landmarks["nipple_L"]
    drawing = {"unit": "mm", "shapes": [{"name": "here", "points": [list(1e3 * nipple)]}]}
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"], "drawing": drawing}
    (shape,) = client.post("/api/transfers", json=wish).json["shapes"]
    goal = read_fit_folder(service.storage.folders.fit(fits["supine"]))
    assert len(shape["points"]) == 1
    there = goal.metres_per_unit * np.array(shape["points"][0])
    assert np.linalg.norm(there - goal.landmarks["nipple_L"]) < 6e-3


def test_what_a_fit_left_may_be_sent_as_it_is_and_a_carried_drawing_sent_back(
    real: tuple[Service, FlaskClient, dict[str, str]],
) -> None:
    service, client, fits = real
    left = json.loads((service.storage.folders.fit(fits["standing"]) / "drawing.json").read_text())
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"]}
    there = client.post("/api/transfers", json=wish | {"drawing": left}).json
    assert there == client.post("/api/transfers", json=wish).json
    back = client.post(
        "/api/transfers", json={"from_fit": wish["to_fit"], "to_fit": wish["from_fit"], "drawing": there}
    )
    assert back.status_code == 201


def test_a_polyline_stays_what_it_is_from_fit_to_file_to_api_to_transfer_to_report(
    real: tuple[Service, FlaskClient, dict[str, str]], tmp_path: Path
) -> None:
    service, client, fits = real
    folder = tmp_path / "fit"
    shutil.copytree(service.storage.folders.fit(fits["standing"]), folder)
    fit = read_fit_folder(folder)
    written = json.loads((folder / "drawing.json").read_text())
    for number, shape in enumerate(written["shapes"]):
        shape["color"] = f"#c0ff0{number}"
    written["shapes"][-1]["error_mm"] = [1.5] * len(written["shapes"][-1]["points"])
    (folder / "drawing.json").write_text(json.dumps(written))
    lines = parsed_drawing((folder / "drawing.json").read_bytes(), fit.rig, fit.unit).on_scan
    assert [shape_document(line, fit.metres_per_unit) for line in lines] == written["shapes"]

    there = [DrawnShape.model_validate(shape).model_dump(exclude={"label"}) for shape in written["shapes"]]
    assert there == written["shapes"]
    millimetres = {"unit": "mm", "shapes": [shape_document(line, 1e-3) for line in lines]}
    scan = client.get(f"/api/fits/{fits['standing']}").json["scan"]
    kept = client.put(f"/api/scans/{scan}/drawing", json=millimetres).json
    on_the_skin = [{key: value for key, value in shape.items() if key != "bridged"} for shape in millimetres["shapes"]]
    assert kept["shapes"] == [{"label": ""} | shape for shape in on_the_skin]
    client.put(f"/api/scans/{scan}/drawing", json={"shapes": []})

    wish = {"from_fit": fits["standing"], "to_fit": fits["standing"], "drawing": millimetres}
    carried = client.post("/api/transfers", json=wish).json["shapes"]
    assert [list(shape) for shape in carried] == [CARRIED_FIELDS] * len(lines)
    for line, shape in zip(lines, parsed_drawing({"shapes": carried}, fit.rig, fit.unit).on_scan, strict=True):
        assert (shape.name, shape.closed, shape.color) == (line.name, line.closed, line.color)
        assert shape.distances(line.points[~line.bridged]).max() < 0.5e-3

    reported = stance_of(folder, fit).lines
    for line, shown in zip(lines, reported, strict=True):
        assert (shown.name, shown.closed, shown.color) == (line.name, line.closed, line.color)
        for field in ("points", "bridged", "error"):
            np.testing.assert_array_equal(getattr(shown, field), getattr(line, field))


@pytest.mark.parametrize(
    ("drawing", "sentence"),
    [
        ({"shapes": []}, "This drawing is empty; draw at least one line or point first."),
        ({"shapes": [{"name": "a", "points": []}]}, "This drawing is empty; draw at least one line or point first."),
        ({"unit": "m", "shapes": [{"name": "a", "points": [[9, 9, 9]]}]}, 'Point 1 of "a" is '),
        (
            {"shapes": [{"name": "a", "surface_points": [{"face": 99999, "barycentric": [1, 0, 0]}]}]},
            "another model",
        ),
        ({"shapes": [{"name": "a", "color": "red"}]}, "color"),
    ],
)
def test_what_cannot_be_carried_is_one_sentence(
    drawing: dict, sentence: str, real: tuple[Service, FlaskClient, dict[str, str]]
) -> None:
    _, client, fits = real
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"], "drawing": drawing}
    answer = client.post("/api/transfers", json=wish)
    assert (answer.status_code, answer.mimetype) == (422, "application/problem+json")
    assert sentence in answer.json["detail"]
    assert answer.json["detail"].endswith(".")


def test_unknown_fits_and_fits_that_are_not_done_are_refused(
    client: FlaskClient, service: Service, scan_id: str, fit_id: str
) -> None:
    for pair in ((fit_id, "nothing"), ("nothing", fit_id)):
        answer = client.post("/api/transfers", json={"from_fit": pair[0], "to_fit": pair[1]})
        assert answer.status_code == 404
    running = client.post("/api/fits", json={"scan": scan_id, "preset": "paper"}).json["id"]
    answer = client.post("/api/transfers", json={"from_fit": fit_id, "to_fit": running})
    assert answer.status_code == 409
    client.post(f"/api/fits/{running}/cancel")
    assert ended(service, running).state == "cancelled"


def test_a_sentence_about_damaged_files_names_no_place_of_the_server(
    client: FlaskClient, service: Service, fit_id: str
) -> None:
    answer = client.post("/api/transfers", json={"from_fit": fit_id, "to_fit": fit_id})
    assert answer.status_code == 422  # the fits of this service write no real files
    assert str(service.storage.root) not in json.dumps(answer.json)
