"""Regnault's grade of ptosis: its limits, on the model whose breasts hang more and more, and where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.report.measures import measures
from breastrig.report.ptosis import GLANDULAR, LEAN, grade
from breastrig.report.stance import Stance
from breastrig.report.table import Row, changes, number, with_band
from breastrig.rig.model import Rig


def by_name(stance: Stance) -> dict[str, Row]:
    return {row.measure: row for row in measures(stance) if row.kind in ("in height", "grade")}


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


def lowered(stance: Stance, nipple_mm: float, side: str = "L") -> Stance:
    """The patient with the nipple picked so far above (below: less than zero) the fold."""
    rig = stance.rig
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(stance.vertices, rig.faces), strict=True))
    nipple, fold = at[f"nipple_{side}"], at[f"inframammary_fold_{side}"]
    pick = np.array([nipple[0], fold[1] + 1e-3 * nipple_mm, nipple[2]])
    return replace(stance, picked={**stance.picked, f"nipple_{side}": pick})


@pytest.mark.parametrize("wanted", [12.0, -6.0, -18.0, -41.0])
def test_the_nipples_height_is_measured_against_the_fold_of_its_own_side(at_rest: Stance, wanted: float) -> None:
    rows = by_name(lowered(at_rest, wanted))
    heights, before = rows["nipple_above_fold"], by_name(at_rest)["nipple_above_fold"]
    assert heights.left is not None
    assert heights.left.value == pytest.approx(wanted, abs=0.01)
    assert heights.right == before.right
    graded = rows["ptosis"]
    assert graded.left is not None
    assert rows["lowest_point_above_fold"].left is not None
    assert graded.left.value == grade(1e-3 * wanted, 1e-3 * rows["lowest_point_above_fold"].left.value)
    assert graded.difference is None


def test_more_ptosis_of_the_model_is_a_lower_nipple_and_contour(at_rest: Stance, asymmetric: Stance) -> None:
    rest, hanging = by_name(at_rest), by_name(asymmetric)
    for measure, least_mm in (("nipple_above_fold", 2.0), ("lowest_point_above_fold", 0.3)):
        before, after = rest[measure].left, hanging[measure].left
        assert before is not None
        assert after is not None
        assert after.value < before.value - least_mm, measure


def test_the_band_knows_the_landmarks_radii_and_the_lean_and_opens_the_grades_it_crosses(at_rest: Stance) -> None:
    stance = lowered(at_rest, -2.0)
    radii = dict.fromkeys(stance.rig.landmark_names, 0.003) | {"nipple_L": 0.004}
    known = replace(stance, landmark_radii=radii, radii=np.full(len(stance.vertices), 0.006))
    rows = by_name(known)
    value, graded = rows["nipple_above_fold"].left, rows["ptosis"].left
    assert value is not None
    assert value.high is not None
    places = dict(
        zip(
            known.rig.landmark_names,
            known.rig.landmark_points().positions(known.vertices, known.rig.faces),
            strict=True,
        )
    )
    offset = (stance.picked["nipple_L"] - places["inframammary_fold_L"])[[0, 2]]
    assert value.high - value.value == pytest.approx(
        1e3 * np.linalg.norm([0.004, 0.003, LEAN * np.linalg.norm(offset)]), rel=1e-3
    )
    assert graded is not None
    assert (graded.low, graded.value, graded.high) == (0.0, 1.0, 1.0)
    assert with_band(graded, "grade") == "I  (none to I)"
    assert number(graded, "grade") == "I"


def test_a_lying_patient_has_no_grade_and_grades_are_not_subtracted(at_rest: Stance) -> None:
    assert by_name(replace(at_rest, name="supine")) == {}
    rows = measures(at_rest)
    assert "ptosis" not in {row.measure for row in changes(rows, rows)}


def test_a_rig_without_outlines_of_the_breasts_has_no_grade(toy_rig: Rig) -> None:
    scan = np.array(toy_rig.template)
    assert by_name(Stance(toy_rig, scan, scan, toy_rig.faces, "standing")) == {}
