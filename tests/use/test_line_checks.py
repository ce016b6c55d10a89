"""Landmarks that a fit wants checked, the same by Python, file and task; for which lines, and why there are none."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.drawings.line_error import ACROSS, fingers
from breastrig.files.result import CHECKS, FIT_FILES, ResultFile
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.use.lines.checks_on_fit import ChecksJob, checks_on_fit
from breastrig.use.lines.line_checks import EARLIER, NO_GAIN, NONE_LEFT, PREDICTED, UNKNOWN, line_checks

SCAN = asset_folder("example") / "supine" / "scan.ply"


@pytest.fixture(scope="module")
def alone() -> breastrig.Fit:
    """The example patient's lying scan, nothing picked."""
    return breastrig.fit(SCAN, stance="supine")


@pytest.fixture(scope="module")
def folder(alone: breastrig.Fit, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("checks") / "fit"
    alone.save(place)
    return place


def test_checks_narrow_the_lines_one_after_another(alone: breastrig.Fit) -> None:
    found = alone.checks()
    assert (found.lines, found.line_error_mm, found.reason) == ("drawing", alone.drawn_line_error_mm, None)
    assert found.line_error_mm is not None
    widths = [found.line_error_mm, *(each.line_error_mm for each in found.checks)]
    assert 1 <= len(found.checks) <= 3
    assert (np.diff(widths) <= 0.0).all()
    assert widths[-1] == found.expected_line_error_mm
    assert found.worth_it
    assert fingers(1e-3 * widths[0]) - fingers(1e-3 * widths[-1]) >= 1 or widths[0] - widths[-1] >= 10.0
    for each in found.checks:
        assert each.name not in alone.picked
        nearest = alone.metres_per_unit * np.linalg.norm(alone.scan_vertices - each.place, axis=1)
        assert nearest.min() < 0.01, "on the scan's skin, in its unit"
        assert np.linalg.norm(each.normal) == pytest.approx(1.0)
        corners = alone.vertices[alone.faces[each.face]]
        assert alone.metres_per_unit * np.linalg.norm(each.barycentric @ corners - each.place) < 0.06
        assert each.radius_mm > 0.0


def test_a_true_check_narrows_the_lines_about_as_promised(alone: breastrig.Fit) -> None:
    truth, unit = read_landmarks(breastrig.example("supine").landmarks)
    assert unit == "mm"
    found = alone.checks()
    places = {each.name: 1e-3 * np.array(truth[each.name]) / alone.metres_per_unit for each in found.checks}
    checked = breastrig.fit(SCAN, places, stance="supine")
    assert found.line_error_mm is not None
    assert found.expected_line_error_mm is not None
    assert checked.drawn_line_error_mm is not None
    assert checked.drawn_line_error_mm == pytest.approx(found.expected_line_error_mm, rel=0.25)
    assert checked.drawn_line_error_mm < found.line_error_mm
    left = checked.checks()
    assert {each.name for each in left.checks}.isdisjoint(checked.picked)


def test_a_loaded_fit_and_the_task_of_the_service_say_the_same(alone: breastrig.Fit, folder: Path) -> None:
    made, loaded, document = alone.checks(), breastrig.Fit.load(folder).checks(), checks_on_fit(ChecksJob(folder))
    assert [each.name for each in made.checks] == [each["name"] for each in document["checks"]]
    for here, there, sent in zip(made.checks, loaded.checks, document["checks"], strict=True):
        assert here.line_error_mm == pytest.approx(there.line_error_mm, abs=0.11), "files round"
        assert sent["line_error_mm"] == there.line_error_mm
        np.testing.assert_allclose(sent["place"], 1e3 * alone.metres_per_unit * here.place, atol=1e-3)
        np.testing.assert_array_equal(here.place, there.place)
        assert sent["side"] == (here.name[-1] if here.name.endswith(("_L", "_R")) else None)
        assert sent["fingers"] == fingers(1e-3 * sent["line_error_mm"])
    assert (document["lines"], document["worth_it"], document["reason"]) == ("drawing", True, None)


def plan_of(fit: breastrig.Fit, error_mm: float | None, *, carried: bool) -> dict[str, Any]:
    """The fit's last line, a breast's, as the plan on its scan has it."""
    shape = dict(fit.drawing.document["shapes"][-1]) | {"carried": carried}
    if error_mm is not None:
        shape["error_mm"] = [error_mm] * len(shape["points"])
    return {"schema": "breastrig/drawing@1", "unit": fit.unit, "shapes": [shape]}


def test_the_plan_on_the_scan_counts_alone_or_beside_the_fits_own_drawing(alone: breastrig.Fit, folder: Path) -> None:
    document = plan_of(alone, None, carried=False)
    whole = checks_on_fit(ChecksJob(folder, (document, True)))
    assert whole["lines"] == "plan"
    assert whole["line_error_mm"] == document["shapes"][0]["line_error_mm"]
    beside = checks_on_fit(ChecksJob(folder, (document, False)))
    assert (beside["lines"], beside["line_error_mm"]) == ("plan", alone.drawn_line_error_mm)
    empty = checks_on_fit(ChecksJob(folder, (document | {"shapes": []}, False)))
    assert empty["lines"] == "drawing"
    erased = checks_on_fit(ChecksJob(folder, (document | {"shapes": []}, True)))
    assert (erased["lines"], erased["line_error_mm"]) == ("breasts", alone.line_error_mm)
    assert erased["checks"]


def test_a_check_does_not_narrow_what_a_line_brought_from_another_scan(alone: breastrig.Fit, folder: Path) -> None:
    own = checks_on_fit(ChecksJob(folder, (plan_of(alone, None, carried=False), True)))
    error = 1.02 * own["line_error_mm"] / ACROSS
    brought = checks_on_fit(ChecksJob(folder, (plan_of(alone, error, carried=True), True)))
    assert brought["line_error_mm"] == pytest.approx(ACROSS * error, abs=0.06)
    gains = [each["line_error_mm"] - each["expected_line_error_mm"] for each in (own, brought)]
    assert 0.0 < gains[1] < gains[0]
    unknown = checks_on_fit(ChecksJob(folder, (plan_of(alone, 10.0 * error, carried=True), True)))
    assert (unknown["checks"], unknown["reason"]) == ([], NO_GAIN)


def test_lines_of_a_program_have_the_fits_errors(alone: breastrig.Fit) -> None:
    line = alone.drawing.lines[0]
    own = breastrig.Line("own", line.points)
    found = alone.checks([own])
    assert found.lines == "drawing"
    assert found.line_error_mm == pytest.approx(line.line_error_mm, abs=0.2)
    assert alone.checks([breastrig.project(alone, line.points)]).line_error_mm == pytest.approx(
        line.line_error_mm, abs=0.5
    )


def test_why_there_are_no_checks_is_one_sentence(alone: breastrig.Fit) -> None:
    fit = alone.in_metres

    def reason(**changed: object) -> str:
        result = ResultFile.model_validate(fit.result.document() | changed)
        found = line_checks(replace(fit, result=result))
        assert (found.checks, found.worth_it, found.expected_line_error_mm) == ((), False, None)
        assert found.reason is not None
        return found.reason

    assert reason(predicted=True) == PREDICTED
    unusable = {"level": "unusable", "reasons": ["It lies elsewhere; place at least three landmarks by hand."]}
    assert reason(verdict=unusable).startswith("This fit cannot be used: It lies elsewhere")
    assert line_checks(replace(fit, radii=None, checks=None)).reason == UNKNOWN
    assert line_checks(replace(fit, checks=None)).reason == EARLIER
    assert fit.checks is not None
    shut = replace(fit.checks.observable, open=np.zeros_like(fit.checks.observable.open))
    assert line_checks(replace(fit, checks=replace(fit.checks, observable=shut))).reason == NONE_LEFT


def test_a_landmark_that_was_cut_away_by_hand_is_not_to_be_checked(alone: breastrig.Fit, folder: Path) -> None:
    """A lasso of 8 cm around the first one, seen along its normal; the fit was made before."""
    first = alone.checks().checks[0]
    place, normal = alone.metres_per_unit * first.place, first.normal
    right = np.cross([0.0, 1.0, 0.0], normal)
    axes = np.stack([right / np.linalg.norm(right), np.cross(normal, right / np.linalg.norm(right)), -normal])
    picture = np.eye(4)
    picture[:3, :3], picture[:3, 3] = axes, -axes @ place
    picture[2] *= 1e-3
    square = [[x, y] for x, y in ((-0.04, -0.04), (0.04, -0.04), (0.04, 0.04), (-0.04, 0.04))]
    cut = {"to_picture": picture.T.ravel().tolist(), "lasso": square}
    left = checks_on_fit(ChecksJob(folder, cuts=(cut,)))
    assert first.name not in {each["name"] for each in left["checks"]}
    assert left["line_error_mm"] == alone.drawn_line_error_mm, "nothing else has changed"
    away = cut | {"lasso": [[x + 5.0, y] for x, y in square]}
    assert checks_on_fit(ChecksJob(folder, cuts=(away,))) == checks_on_fit(ChecksJob(folder))


def test_the_file_is_one_of_the_fits_and_may_be_missing(folder: Path, tmp_path: Path) -> None:
    assert CHECKS in FIT_FILES
    for name in FIT_FILES:
        if name != CHECKS:
            (tmp_path / name).write_bytes((folder / name).read_bytes())
    assert breastrig.Fit.load(tmp_path).checks().reason == EARLIER
