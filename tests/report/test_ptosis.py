"""Regnault's grade of ptosis: its limits, on the model whose breasts hang more and more, and where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import measure_calibration
from breastrig.report.measures import measures
from breastrig.report.ptosis import GLANDULAR, LEAN, grade, ptosis
from breastrig.report.stance import Stance, places
from breastrig.report.table import Row, changes, grade_text
from breastrig.rig.model import Rig

PICKS = ("nipple_L", "nipple_R", "inframammary_fold_L", "inframammary_fold_R")


def by_name(stance: Stance) -> dict[str, Row]:
    """These rows alone; that the table of all measures has them is seen where they are subtracted."""
    return {row.measure: row for row in ptosis(stance, body_frame(stance.rig, stance.vertices), places(stance))}


@pytest.mark.parametrize(
    ("nipple", "lowest", "expected"),
    [
        (20, -5, 0), (0, -19, 0), (0, -20, GLANDULAR), (25, -40, GLANDULAR),
        (-1, -30, 1), (-10, -30, 1), (-11, -30, 2), (-30, -45, 2), (-31, -60, 3),
        (-20, -29, 3), (-20, -31, 2), (-5, -8, 1),
    ],
)  # fmt: skip
def test_grades_end_where_the_article_and_its_usual_reading_say(nipple: float, lowest: float, expected: float) -> None:
    assert grade(1e-3 * nipple, 1e-3 * lowest) == expected


def landmarks(stance: Stance) -> dict[str, np.ndarray]:
    rig = stance.rig
    return dict(zip(rig.landmark_names, rig.landmark_points().positions(stance.vertices, rig.faces), strict=True))


def picked(stance: Stance, *names: str) -> Stance:
    """The patient with these landmarks picked where the model has them."""
    return replace(stance, picked={name: landmarks(stance)[name] for name in (*PICKS, *names)})


def lowered(stance: Stance, nipple_mm: float, side: str = "L") -> Stance:
    """The patient, nipples and folds picked, one nipple so far above (below: less than zero) the fold."""
    at = landmarks(stance)
    nipple, fold = at[f"nipple_{side}"], at[f"inframammary_fold_{side}"]
    pick = np.array([nipple[0], fold[1] + 1e-3 * nipple_mm, nipple[2]])
    return replace(stance, picked=picked(stance).picked | {f"nipple_{side}": pick})


@pytest.mark.parametrize("wanted", [12.0, -6.0, -18.0, -41.0])
def test_the_nipples_height_is_measured_against_the_fold_of_its_own_side(at_rest: Stance, wanted: float) -> None:
    rows = by_name(lowered(at_rest, wanted))
    heights, before = rows["nipple_above_fold"], by_name(picked(at_rest))["nipple_above_fold"]
    assert heights.left.value == pytest.approx(wanted, abs=0.01)
    assert heights.right == before.right
    graded = rows["ptosis"]
    assert graded.left.value == grade(1e-3 * wanted, 1e-3 * rows["lowest_point_above_fold"].left.value)
    assert graded.difference is None


def test_more_ptosis_of_the_model_is_a_lower_nipple_and_contour(at_rest: Stance, asymmetric: Stance) -> None:
    rest, hanging = by_name(picked(at_rest)), by_name(picked(asymmetric))
    for measure, least_mm in (("nipple_above_fold", 2.0), ("lowest_point_above_fold", 0.3)):
        before, after = rest[measure].left, hanging[measure].left
        assert after.value < before.value - least_mm, measure


def test_the_band_of_picked_heights_is_a_clicks_and_the_leans_and_opens_the_grades_it_crosses(at_rest: Stance) -> None:
    stance = lowered(at_rest, -2.0)
    radii = dict.fromkeys(stance.rig.landmark_names, 0.015)  # what the fit thinks of the model there
    known = replace(stance, landmark_radii=radii, radii=np.full(len(stance.vertices), 0.006))
    rows, errors = by_name(known), measure_calibration(at_rest.rig).heights
    value, graded, low = (rows[name].left for name in ("nipple_above_fold", "ptosis", "lowest_point_above_fold"))
    offset = (stance.picked["nipple_L"] - stance.picked["inframammary_fold_L"])[[0, 2]]
    assert value.high - value.value == pytest.approx(
        1e3 * np.linalg.norm([errors.picked, errors.picked, LEAN * np.linalg.norm(offset)]), rel=1e-3
    )
    assert low.high - low.value >= 1e3 * np.hypot(errors.picked, errors.lowest)
    assert (graded.low, graded.value) == (0.0, 1.0)
    assert grade_text(graded).split()[0] == "I"
    assert grade_text(graded).startswith("I  (none to ")


def test_a_nipple_that_nobody_picked_or_sees_gives_no_grade(at_rest: Stance) -> None:
    """The fit leaves the nipple of a hanging breast far too high; one side may be known alone."""
    assert by_name(at_rest) == {}
    rows = by_name(replace(at_rest, seen={"nipple_R": landmarks(at_rest)["nipple_R"]}))
    assert rows.keys() == {"nipple_above_fold", "lowest_point_above_fold", "ptosis"}
    for row in rows.values():
        assert row.left is None
        assert row.right is not None
        assert row.paths.keys() == {"right"}
        assert row.difference is None
    assert "left nipple is neither picked nor seen" in rows["ptosis"].method


def test_a_fold_that_its_breast_covers_is_taken_at_the_xiphoids_level(at_rest: Stance) -> None:
    at, errors = landmarks(at_rest), measure_calibration(at_rest.rig).heights
    low = at["nipple_L"] - [0.0, at["nipple_L"][1] - at["xiphoid"][1] + 0.02, 0.0]  # 20 mm under the xiphoid's level
    radii = dict.fromkeys(at_rest.rig.landmark_names, 0.01)
    stance = replace(
        at_rest,
        picked={"nipple_L": low, "nipple_R": at["nipple_R"], "xiphoid": at["xiphoid"]},
        landmark_radii=radii,
        radii=np.full(len(at_rest.vertices), 0.006),
    )
    row = by_name(stance)["nipple_above_fold"]
    assert row.right is not None
    assert row.left.value == pytest.approx(-20.0 - 1e3 * errors.fold_over_xiphoid, abs=0.01)
    assert row.left.value - row.left.low > 1e3 * errors.hidden_fold
    assert {"xiphoid (picked)", "inframammary_fold_R (model)"} <= set(row.landmarks)
    assert "inframammary_fold_L (model)" not in row.landmarks
    shown = by_name(replace(stance, picked={**stance.picked, "inframammary_fold_L": at["inframammary_fold_L"]}))
    assert "inframammary_fold_L (picked)" in shown["nipple_above_fold"].landmarks


def test_a_lying_patient_has_no_grade_and_grades_are_not_subtracted(at_rest: Stance) -> None:
    assert by_name(replace(picked(at_rest), name="supine")) == {}
    rows = measures(picked(at_rest))
    shown = {row.measure: row.left for row in rows if row.kind in ("in height", "grade")}
    assert shown == {name: row.left for name, row in by_name(picked(at_rest)).items()}
    assert "ptosis" not in {row.measure for row in changes(rows, rows)}


def test_a_rig_without_outlines_of_the_breasts_has_no_grade(toy_rig: Rig) -> None:
    scan = np.array(toy_rig.template)
    nipples = dict.fromkeys(("nipple_L", "nipple_R"), scan[0])
    assert by_name(Stance(toy_rig, scan, scan, toy_rig.faces, "standing", nipples)) == {}
