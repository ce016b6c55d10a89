"""`breastrig.Case`: a scan read, landmarks placed, a fit kept with its events, a plan carried, all in one folder."""

import json
from pathlib import Path

import numpy as np
import pytest

import breastrig
from breastrig.cases.case_folder import CaseFolder
from breastrig.core.assets import asset_folder
from breastrig.core.errors import Conflict, NeedsYes
from breastrig.files.result import FIT_FILES
from breastrig.use.cases.case_work import asked_fit, fit_events

EXAMPLE = asset_folder("example")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> breastrig.Case:
    """With the standing example, its landmarks and one fit."""
    case = breastrig.Case.create(tmp_path_factory.mktemp("cases") / "her", "K7M-4QX")
    scan = case.add_scan(EXAMPLE / "standing" / "scan.ply")
    case.put_landmarks(scan, EXAMPLE / "standing" / "landmarks.json", certain=["umbilicus"])
    case.fit(scan)
    return case


def test_a_scan_comes_back_to_the_bit(case: breastrig.Case) -> None:
    given = breastrig.read_scan(EXAMPLE / "standing" / "scan.ply")
    kept = case.read_scan(case.scans[0].id)
    assert np.array_equal(kept.vertices, given.vertices)
    assert np.array_equal(kept.faces, given.faces)
    assert (kept.unit, kept.sha256) == (given.unit, given.sha256)
    assert (case.scans[0].stance, case.code) == ("standing", "K7M-4QX")
    assert {path.name for path in case.scans[0].folder.iterdir()} >= {"mesh.glb", "thumbnail.png", "scan.stored"}


def test_landmarks_come_back_in_the_scans_unit(case: breastrig.Case) -> None:
    given = json.loads((EXAMPLE / "standing" / "landmarks.json").read_text())["landmarks"]
    scan = case.scans[0].id
    found, per_unit_mm = case.landmarks(scan), 1e3 * case.read_scan(scan).metres_per_unit
    assert set(found) == set(given)
    assert all(np.allclose(per_unit_mm * found[name], given[name], atol=1e-9) for name in given)


def test_marks_are_kept_with_the_landmarks_and_given_to_the_fit(tmp_path: Path) -> None:
    case = breastrig.Case.create(tmp_path / "hers", "K7M-4QX")
    scan = case.add_scan(EXAMPLE / "standing" / "scan.ply")
    place = case.read_scan(scan).vertices[1000]
    (tmp_path / "picks.csv").write_text(f"dot,{','.join(map(str, place))}\n")
    case.put_landmarks(scan, tmp_path / "picks.csv", marks={"mole": place})
    assert case.landmarks(scan) == {}
    assert {name: at.tolist() for name, at in case.marks(scan).items()} == {
        name: pytest.approx(place.tolist()) for name in ("dot", "mole")
    }
    assert list(case.fit(scan, refine=False).marks) == ["dot", "mole"]
    with pytest.raises(breastrig.BadLandmarks, match='"dot" stands twice'):
        case.put_landmarks(scan, tmp_path / "picks.csv", marks={"dot": place})


def test_the_fit_is_that_of_the_command_line_and_its_log_its_events(case: breastrig.Case) -> None:
    scan = case.scans[0]
    [kept] = case.fits(scan.id)
    fit = case.load_fit(kept.id)
    alone = breastrig.fit(
        EXAMPLE / "standing" / "scan.ply", EXAMPLE / "standing" / "landmarks.json", certain=["umbilicus"]
    )
    assert np.abs(fit.vertices - alone.vertices).max() < 1e-3 * (0.001 / fit.metres_per_unit)
    assert (kept.state, kept.stance, kept.verdict) == ("done", "standing", alone.verdict.level)
    assert {path.name for path in kept.folder.iterdir()} >= set(FIT_FILES)
    events = [json.loads(line) for line in (kept.folder / "fit.log.jsonl").read_text().splitlines()]
    assert [event["kind"] for event in events] == ["started", *["iterated"] * (len(events) - 2), "done"]
    assert all("nodes" in event for event in events[1:-1])
    written = json.loads((kept.folder / "result.json").read_text())
    assert events[-1]["result"] == {name: value for name, value in written.items() if name != "fields"}


def test_a_plan_is_replaced_by_who_has_seen_it_and_undone(case: breastrig.Case) -> None:
    scan = case.scans[0].id
    line = {"kind": "line", "id": "one", "scan": scan, "name": "cut", "points": [[0, 0, 100], [10, 0, 100]]}
    seen = case.plan_etag
    first = case.put_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": [line]}, seen)
    with pytest.raises(Conflict, match="Somebody has changed this"):
        case.put_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": []}, seen)
    case.put_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": []}, case.plan_etag)
    assert case.plan()["items"] == []
    assert case.undo(first) == first + 2
    plan = case.plan()
    assert [item["name"] for item in plan["items"]] == ["cut"]
    assert (plan["patient"], plan["scans"][0]["sha256"]) == (case.code, case.scans[0].sha256)
    assert case.put_plan(plan) == first + 3  # what was read can be written
    with pytest.raises(NeedsYes):
        case.put_plan(plan | {"patient": "ANOTHER", "scans": []})
    without = {key: value for key, value in line.items() if key != "scan"}
    with pytest.raises(breastrig.BadInput, match="does not say on which scan"):
        case.put_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": [without]})
    with pytest.raises(breastrig.BadDrawing, match="flower"):
        case.put_plan(
            {"schema": "breastrig/plan@1", "items": [{"kind": "pattern", "id": "p", "name": "flower"}]}, scan=scan
        )


def test_a_prediction_is_kept_as_a_fit(case: breastrig.Case) -> None:
    scan = case.scans[0].id
    fit = case.fits(scan)[0]
    found = case.predict(fit.id, "supine")
    kept = case.fits(scan)[-1]
    assert (kept.state, kept.stance, kept.predicted_from) == ("done", "supine", fit.id)
    alone = breastrig.predict(case.load_fit(fit.id), "supine")
    assert np.array_equal(found.vertices, alone.vertices)
    with pytest.raises(breastrig.BadInput, match="itself predicted"):
        case.predict(kept.id, "prone")
    with pytest.raises(breastrig.BadInput, match="standing already"):
        case.predict(fit.id, "standing")
    with pytest.raises(breastrig.BadInput, match="auto"):
        case.predict(fit.id, "auto")


def test_a_fit_goes_on_from_an_earlier_one(case: breastrig.Case) -> None:
    folder, scan = CaseFolder(case.path), case.scans[0].id
    first = case.fits(scan)[0]
    events = list(fit_events(folder, scan, asked_fit(folder, scan, start_from=first.id, drawing=None)))
    again = case.fits(scan)[-1].id
    assert len(events) < len((first.folder / "fit.log.jsonl").read_text().splitlines())
    assert case.load_fit(again).stance == "standing"


def test_who_stops_a_fit_cancels_it_and_a_failed_one_says_why(case: breastrig.Case) -> None:
    scan = case.scans[0].id
    run = case.fitting(scan)
    assert next(run).kind == "started"
    run.close()
    assert case.fits(scan)[-1].state == "cancelled"
    with pytest.raises(breastrig.BadDrawing):
        case.fit(scan, drawing="flower")
    failed = case.fits(scan)[-1]
    assert failed.state == "failed"
    assert failed.reason is not None
    assert "flower" in failed.reason
    with pytest.raises(breastrig.FitFailed, match="flower"):
        case.load_fit(failed.id)


def test_a_file_that_is_there_already_is_asked_about(case: breastrig.Case, tmp_path: Path) -> None:
    with pytest.raises(NeedsYes):
        case.add_scan(EXAMPLE / "standing" / "scan.ply")
    other = breastrig.Case.create(tmp_path / "other")
    scan = other.add_scan(EXAMPLE / "supine" / "scan.ply")
    other.move_scan(scan, case)
    assert not (tmp_path / "other").exists()
    case.delete_scan(scan)
    assert [each.id for each in case.scans] != [scan]


def test_what_is_no_scan_leaves_nothing(tmp_path: Path) -> None:
    case = breastrig.Case.create(tmp_path / "case")
    (tmp_path / "text.ply").write_text("hello")
    for bad in (tmp_path / "text.ply", tmp_path / "nothing.ply"):
        with pytest.raises(breastrig.BadScan):
            case.add_scan(bad)
    with pytest.raises(breastrig.BadInput, match="unit"):
        case.add_scan(EXAMPLE / "standing" / "scan.ply", "miles")
    assert case.scans == ()
    case.delete()
    with pytest.raises(breastrig.BadInput, match="There is no case"):
        breastrig.Case(tmp_path / "case")
