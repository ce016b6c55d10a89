"""Drawings carried between two fits of the service: the real work on the example patient, and what is refused."""

import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.other_body import with_other_body
from helpers.problems import problem
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.drawings.drawing_file import parsed_drawing, rounded_mm, shape_document
from breastrig.drawings.drawing_schema import DrawnShape
from breastrig.drawings.line_error import across
from breastrig.execution.limits import FitLimits
from breastrig.execution.pool import TaskQueue
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.reports.report import planned_lines

pytestmark = pytest.mark.long

CARRIED_FIELDS = ["name", "closed", "color", "points", "bridged", "error_mm", "line_error_mm"]
CARRIED_FIELDS += ["distance_from_mm", "distance_to_mm"]


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient, dict[str, str]]]:
    """A service with the fits of the example patient standing and lying."""
    storage = Storage(tmp_path_factory.mktemp("transfers"))
    service = Service(storage, runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        client = create_app(Config(), service).test_client()
        fits = {}
        for name in ("standing", "supine"):
            scan = client.post(f"/api/examples/{name}").json
            picked = scan["example_landmarks"]["landmarks"]
            fits[name] = client.post(
                "/api/fits", json={"scan": scan["id"], "landmarks": picked, "drawing": "lumpectomy"}
            ).json["id"]
            assert ended(service, fits[name]).state == "done"
        yield service, client, fits


@pytest.mark.slow
def test_the_fits_own_drawing_is_shown_on_the_other_scan(real: tuple[Service, FlaskClient, dict[str, str]]) -> None:
    """Where it lies is a question of tests/cli/test_transfer_command.py."""
    service, client, fits = real
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"]}
    answer = client.post("/api/transfers", json=wish)
    assert answer.status_code == 201, answer.json
    drawing = answer.json
    assert drawing["carried_by"] == "skin"
    assert {shape["name"] for shape in drawing["shapes"]} == {"sternum_upper", "sternum_lower", "breast_L", "breast_R"}
    assert drawing["unit"] == read_fit_folder(service.storage.files.fit(fits["supine"])).unit
    assert [gap is None for gap in drawing["shapes"][0]["distance_to_mm"]] == drawing["shapes"][0]["bridged"]
    left = json.loads((service.storage.files.fit(fits["standing"]) / "drawing.json").read_text())
    assert client.post("/api/transfers", json=wish | {"drawing": left}).json == drawing, "it may be sent as it is"
    back = {"from_fit": wish["to_fit"], "to_fit": wish["from_fit"], "drawing": drawing, "other_patient": True}
    returned = client.post("/api/transfers", json=back)
    assert (returned.status_code, returned.json["carried_by"]) == (201, "model")


@pytest.mark.slow
def test_a_drawing_of_the_caller_comes_back_in_the_other_scans_unit(
    real: tuple[Service, FlaskClient, dict[str, str]],
) -> None:
    service, client, fits = real
    nipple = read_fit_folder(service.storage.files.fit(fits["standing"])).landmarks["nipple_L"]
    drawing = {"unit": "mm", "shapes": [{"name": "here", "points": [list(1e3 * nipple)]}]}
    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"], "drawing": drawing}
    (shape,) = client.post("/api/transfers", json=wish).json["shapes"]
    goal = read_fit_folder(service.storage.files.fit(fits["supine"]))
    assert len(shape["points"]) == 1
    there = goal.metres_per_unit * np.array(shape["points"][0])
    assert np.linalg.norm(there - goal.landmarks["nipple_L"]) < 6e-3


@pytest.mark.slow
def test_a_polyline_stays_what_it_is_from_fit_to_file_to_api_to_transfer_to_report(
    real: tuple[Service, FlaskClient, dict[str, str]], tmp_path: Path
) -> None:
    service, client, fits = real
    folder = tmp_path / "fit"
    shutil.copytree(service.storage.files.fit(fits["standing"]), folder)
    fit = read_fit_folder(folder)
    written = json.loads((folder / "drawing.json").read_text())
    for number, shape in enumerate(written["shapes"]):
        shape["color"] = f"#c0ff0{number}"
    written["shapes"][-1]["error_mm"] = [1.5] * len(written["shapes"][-1]["points"])
    written["shapes"][-1]["line_error_mm"] = rounded_mm(1e-3 * across(np.array([1.5])))
    (folder / "drawing.json").write_text(json.dumps(written))
    lines = parsed_drawing((folder / "drawing.json").read_bytes(), fit.rig, fit.unit).on_scan
    assert [shape_document(line, fit.metres_per_unit) for line in lines] == written["shapes"]

    there = [DrawnShape.model_validate(shape).model_dump(exclude={"label"}) for shape in written["shapes"]]
    assert there == written["shapes"]
    millimetres = {"unit": "mm", "shapes": [shape_document(line, 1e-3) for line in lines]}
    scan = client.get(f"/api/fits/{fits['standing']}").json["scan"]
    kept = client.put(f"/api/scans/{scan}/drawing", json=millimetres).json
    said_of_points = [{key: shape[key] for key in shape if key != "line_error_mm"} for shape in millimetres["shapes"]]
    assert kept["shapes"] == [{"label": ""} | shape for shape in said_of_points]
    client.put(f"/api/scans/{scan}/drawing", json={"shapes": []})

    wish = {"from_fit": fits["standing"], "to_fit": fits["standing"], "drawing": millimetres}
    carried = client.post("/api/transfers", json=wish).json["shapes"]
    assert [list(shape) for shape in carried] == [CARRIED_FIELDS] * len(lines)
    for line, shape in zip(lines, parsed_drawing({"shapes": carried}, fit.rig, fit.unit).on_scan, strict=True):
        assert (shape.name, shape.closed, shape.color) == (line.name, line.closed, line.color)
        assert shape.distances(line.points[~line.bridged]).max() < 0.5e-3

    reported = planned_lines(folder, fit.unit, None)
    for line, shown in zip(lines, reported, strict=True):
        assert (shown.name, shown.closed, shown.color) == (line.name, line.closed, line.color)
        for field in ("points", "bridged", "error"):
            np.testing.assert_array_equal(getattr(shown, field), getattr(line, field))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drawing", "sentence"),
    [
        ({"shapes": []}, "This drawing is empty; draw at least one line or point first."),
        ({"unit": "m", "shapes": [{"name": "a", "points": [[9, 9, 9]]}]}, 'Point 1 of "a" is '),
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


def plan_on(client: FlaskClient, fit: str) -> dict[str, Any]:
    answer = client.get(f"/api/fits/{fit}/plan.json")
    assert answer.status_code == 200, answer.json
    return dict(answer.json)


def stored_tag(answer: Any) -> dict[str, str]:
    return {"If-Match": answer.headers["ETag"]}


@pytest.mark.slow
def test_a_whole_plan_is_carried_and_nothing_of_it_is_made_anew_on_the_other_body(
    real: tuple[Service, FlaskClient, dict[str, str]],
) -> None:
    service, client, fits = real
    scans = {name: client.get(f"/api/fits/{fit}").json["scan"] for name, fit in fits.items()}
    standing = client.get(f"/api/scans/{scans['standing']}").json
    client.put(f"/api/scans/{scans['supine']}/patient", json={"patient": standing["patient"]})
    marks = read_fit_folder(service.storage.files.fit(fits["standing"])).landmarks
    nipple = marks["nipple_L"]
    outwards = nipple - np.mean(list(marks.values()), axis=0)
    guessed = list(1e3 * (nipple + 0.012 * outwards / np.linalg.norm(outwards)))  # ink over a hole: nothing is there
    place, tumour_place = list(1e3 * nipple), {"side": "L", "clock": 10.0, "distance_mm": 45.0, "radius_mm": 12.0}
    there = list(1e3 * read_fit_folder(service.storage.files.fit(fits["supine"])).landmarks["nipple_R"])
    items = [
        {"kind": "tumour", "id": "t", "scan": scans["standing"], **tumour_place, "depth_mm": 20.0},
        {"kind": "pattern", "id": "p", "scan": scans["standing"], "name": "reduction", "parameters": {"side": "L"}},
        {"kind": "line", "id": "a", "scan": scans["standing"], "name": "Line 1", "points": [place]},
        {
            "kind": "line",
            "id": "g",
            "scan": scans["standing"],
            "name": "Ink",
            "points": [place, guessed, place],
            "bridged": [False, True, False],
        },
        {"kind": "note", "id": "n", "scan": scans["standing"], "text": "here", "point": place},
        {"kind": "line", "id": "b", "scan": scans["supine"], "name": "Line 1", "points": [there]},
        {"kind": "tumour", "id": "off", "scan": scans["supine"], **tumour_place | {"distance_mm": 200.0}},
    ]
    seen = client.get(standing["links"]["plan"]).headers["ETag"]
    stored = client.put(standing["links"]["plan"], json={"items": items}, headers={"If-Match": seen})
    assert stored.status_code == 200, stored.json
    kept = {each["id"]: each.get("bridged") for each in client.get(standing["links"]["plan"]).json["items"]}
    assert (kept["g"], kept["a"]) == ([False, True, False], None)

    own, carried = plan_on(client, fits["standing"]), plan_on(client, fits["supine"])
    assert [(each["item"], each["carried"]) for each in own["shapes"]] == [
        ("t", False), *[("p", False)] * 4, ("a", False), ("g", False), ("n", False), ("b", True),
    ]  # fmt: skip
    assert [(each["name"], each["item"], each["carried"]) for each in carried["shapes"]][:2] == [
        ("Line 1", "b", False), ("tumour_L", "t", True),
    ]  # fmt: skip
    assert {each["name"] for each in carried["shapes"]} > {"Line 1", "Line 1 (standing)", "tumour_L", "wise_L", "n"}
    for plan in (own, carried):
        assert [each["item"] for each in plan["missing"]] == ["off"]
        assert plan["notes"] == [{"item": "n", "text": "here", "at": "n"}]
    assert next(each for each in own["shapes"] if each["item"] == "g")["bridged"] == [False, True, False]
    assert next(each for each in carried["shapes"] if each["item"] == "t")["depth_mm"] == 20.0

    # an item that was made on a scan without a fit is said to be missing
    third = client.post("/api/examples/supine").json
    client.put(f"/api/scans/{third['id']}/patient", json={"patient": standing["patient"], "again": True})
    more = [*items, {"kind": "line", "id": "z", "scan": third["id"], "name": "Line 9", "points": [there]}]
    stored = client.put(standing["links"]["plan"], json={"items": more}, headers=stored_tag(stored))
    missing = plan_on(client, fits["standing"])["missing"]
    assert [each["item"] for each in missing] == ["off", "z"]
    assert "not fitted yet" in missing[1]["reason"]

    client.put(standing["links"]["plan"], json={"items": []}, headers=stored_tag(stored))
    assert plan_on(client, fits["supine"])["shapes"] == []


@pytest.mark.slow
def test_two_bodies_are_compared_once_for_all_versions_of_their_plan(
    real: tuple[Service, FlaskClient, dict[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    service, client, fits = real
    service.plans.forget()
    result, tasks = TaskQueue.result, Counter[str]()

    def counted(queue: TaskQueue, task: Callable[..., Any], *given: Any, **named: Any) -> Any:
        tasks[task.__name__] += 1
        return result(queue, task, *given, **named)

    monkeypatch.setattr(TaskQueue, "result", counted)
    scans = [client.get(f"/api/scans/{client.get(f'/api/fits/{fit}').json['scan']}").json for fit in fits.values()]
    client.put(f"/api/scans/{scans[1]['id']}/patient", json={"patient": scans[0]["patient"]})
    plan = client.get(scans[0]["links"]["plan"])
    for text in ("before", "after"):
        note = {"kind": "note", "id": "n", "scan": scans[0]["id"], "text": text}
        plan = client.put(scans[0]["links"]["plan"], json={"items": [note]}, headers=stored_tag(plan))
        assert [plan_on(client, fit)["notes"][0]["text"] for fit in fits.values()] == [text, text]
    assert tasks == {"compared_bodies": 2, "plan_on_fit": 4}


@pytest.mark.slow
def test_nothing_is_carried_between_scans_that_do_not_look_like_one_patients_before_somebody_says_so(
    real: tuple[Service, FlaskClient, dict[str, str]],
) -> None:
    service, client, fits = real
    standing, supine = (client.get(f"/api/fits/{fits[name]}").json["scan"] for name in ("standing", "supine"))
    patient = client.get(f"/api/scans/{standing}").json["patient"]
    whose = f"/api/scans/{supine}/patient"
    assert client.put(whose, json={"patient": patient}).status_code == 200
    with_other_body(service.storage.files.fit(fits["supine"]))
    service.plans.forget()  # no fit of a service ever changes
    marks = read_fit_folder(service.storage.files.fit(fits["standing"])).landmarks
    ends = [list(1e3 * marks[name]) for name in ("xiphoid", "mid_sternum")]
    client.put(f"/api/scans/{standing}/drawing", json={"shapes": [{"name": "incision", "points": ends}]})

    def shown() -> tuple[list[str], list[str], list[str]]:
        plan = plan_on(client, fits["supine"])
        missing = [each["reason"] for each in plan["missing"] if "does not look like" in each["reason"]]
        return [shape["name"] for shape in plan["shapes"]], missing, [each["scan"] for each in plan["asked"]]

    wish = {"from_fit": fits["standing"], "to_fit": fits["supine"]}
    names, missing, asked = shown()
    assert "incision" not in names
    assert missing
    assert asked == [standing]
    said = problem(client.post("/api/transfers", json=wish), 409)
    assert said.startswith("These do not look like scans of one patient: ")
    assert said.endswith("say same_patient.")
    assert client.post("/api/transfers", json=wish | {"same_patient": True}).json["doubts"]
    problem(client.put(whose, json={"patient": patient, "same_as": ["nobody"]}), 404)

    assert client.put(whose, json={"patient": patient, "same_as": [standing]}).status_code == 200
    names, missing, asked = shown()
    assert ("incision" in names, missing, asked) == (True, [], [])
    assert plan_on(client, fits["supine"])["doubts"] == []
    answer = client.post("/api/transfers", json=wish)
    assert (answer.status_code, answer.json["doubts"]) == (201, [])

    apart = client.put(whose, json={"patient": None}).json
    assert apart["id"] != patient
    assert [scan["id"] for scan in apart["scans"]] == [supine]
    assert client.put(whose, json={"patient": patient, "again": True}).status_code == 200
    assert shown()[2] == [standing], "whose scan it is was said anew, so what was said before is gone"
