"""Ptosis of a breast: nipple and lowest point above or below the fold, and Regnault's grade.

Regnault 1976 (Clin Plast Surg 3:193), in the usual reading in millimetres, for standing patients:

    I      at the fold or at most 10 mm below it
    II     10 to 30 mm below it, and still above the breast's lowest contour
    III    more than 30 mm below it, or below it and at the lowest contour
    glandular (pseudoptosis): the nipple above the fold, the breast's lowest point well below it

Heights are along the body's axis (body_frame.py). The nipple has to be picked or observed in colour: else fits of
hanging breasts are 15 mm off. A hanging breast hides its fold, which is then taken at the xiphoid's height.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.report.bands import Joint, banded, half_width, shared_half_width
from breastrig.report.body_frame import BodyFrame
from breastrig.report.calibration import Heights, measure_calibration
from breastrig.report.stance import MODEL, Place, Stance
from breastrig.report.table import Row, Value
from breastrig.report.volume import vertices_within

STANDING = "standing"
PICKED = "picked"  # source of a place, stance.py
SLIGHT, MODERATE = 0.010, 0.030  # m of the nipple below the fold: Regnault's I and II end there
AT_CONTOUR = 0.010  # m of the nipple above the breast's lowest point: it is at the lowest contour
GLANDULAR_DROP = 0.020  # m of the lowest point below the fold; a breast that hangs over its fold by less is usual
LEAN = 0.05  # rad; nine of ten body axes of warped standing bodies are within it of the true upright
GLANDULAR = 4.0  # among the grades 0 (none) to 3
OUTLINE = "model inside its breast base outline"


@dataclass(frozen=True, eq=False)
class _Heights:
    """The heights of one breast, m."""

    nipple: float  # above the fold
    nipple_half: float | None  # of its band
    lowest: float  # above the fold; below zero where the breast hangs over it
    lowest_half: float | None
    contour_half: float | None  # of the nipple's height over the lowest point
    nipple_ends: tuple[tuple[Place, float], ...]  # by how much the nipple's height changes with each place, upwards
    own: tuple[float | None, float | None]  # m, 90 %, of nipple and lowest point, of errors that no place has
    over_fold: tuple[Array, Array]  # (3,) m each, nipple and lowest point from the fold
    at: tuple[Array, Array]  # (3,) m, nipple and lowest point
    names: tuple[str, ...]  # nipple and what says where the fold is, with their sources


def grade(nipple: float, lowest: float) -> float:
    """0 none, 1 to 3 as Regnault's I to III, 4 glandular; the heights above the fold in m."""
    if nipple >= 0.0:
        return GLANDULAR if lowest <= -GLANDULAR_DROP else 0.0
    if nipple >= -SLIGHT:
        return 1.0
    return 2.0 if nipple >= -MODERATE and nipple - lowest > AT_CONTOUR else 3.0


def ptosis(stance: Stance, frame: BodyFrame, known: Mapping[str, Place], joint: Joint | None = None) -> Iterator[Row]:
    """Three rows for a standing patient of whom a nipple is known, by a rig with folds and outlines of the breasts."""
    if stance.name != STANDING:
        return
    sides = {side: each for side in SIDES if (each := _heights(stance, frame, known, side)) is not None}
    if not sides:
        return
    up = frame.axes[:, 1]
    landmarks = tuple(dict.fromkeys(name for each in sides.values() for name in each.names))
    folds = tuple(name for name in landmarks if not name.startswith("nipple"))
    unknown = [f"the {name} nipple is neither picked nor seen" for side, name in SIDES.items() if side not in sides]
    nipples = {SIDES[side]: np.stack([each.at[0], each.at[0] - each.nipple * up]) for side, each in sides.items()}
    lowest = {SIDES[side]: np.stack([each.at[1], each.at[1] - each.lowest * up]) for side, each in sides.items()}
    how = "along the body's own axis, above the level of the fold's lowest point; below it less than zero"
    if any(name.startswith("xiphoid") for name in folds):
        how += "; a fold that the breast covers is taken at the xiphoid's level"
    how = "; ".join([how, *unknown])
    both = [sides.get(side) for side in SIDES]
    over = [None if each is None else _mm(each.nipple, each.nipple_half) for each in both]
    under = [None if each is None else _mm(each.lowest, each.lowest_half) for each in both]
    grades = [None if each is None else _graded(each) for each in both]
    between = [_half_between(frame, list(sides.values()), which, joint) for which in (0, 1)]
    yield Row(
        "nipple_above_fold", "Nipple above fold", "in height", "mm", over[0], over[1], None, landmarks, how, nipples,
        between=between[0],
    )  # fmt: skip
    yield Row(
        "lowest_point_above_fold", "Lowest point above fold", "in height", "mm",
        under[0], under[1], None, (*folds, OUTLINE), how, lowest,
        between=between[1],
    )  # fmt: skip
    how = (
        "Regnault: I nipple at the fold or up to 10 mm below, II 10 to 30 mm, III more or at the lowest contour; "
        "glandular: nipple above the fold, lowest point 20 mm and more below it"
    )
    yield Row(
        "ptosis", "Ptosis (Regnault)", "grade", "grade",
        grades[0], grades[1], None, (*landmarks, OUTLINE), "; ".join([how, *unknown]), nipples,
    )  # fmt: skip


def _heights(stance: Stance, frame: BodyFrame, known: Mapping[str, Place], side: str) -> _Heights | None:
    """The heights; None where the rig lacks what is needed (measures.toml too), or only the model gives the nipple."""
    nipple, fold = known.get(f"nipple_{side}"), known.get(f"inframammary_fold_{side}")
    inside = vertices_within(stance.rig, side)
    known_of_rig = measure_calibration(stance.rig)
    if nipple is None or fold is None or inside is None or nipple.source == MODEL or known_of_rig is None:
        return None
    errors = known_of_rig.heights
    skin = stance.vertices[inside]
    low = skin[frame.height(skin).argmin()]
    level, fold_error, at, hidden = _fold(frame, nipple, fold, known.get("xiphoid"), errors)
    above = [float(frame.height(point)) - level for point in (nipple.point, low)]
    own = _error(nipple, errors), None if stance.radii is None else errors.lowest
    halves = [
        half_width([error, fold_error, LEAN * _across(frame, point - fold.point)])
        for point, error in zip((nipple.point, low), own, strict=True)
    ]
    contour = half_width(own)
    ends = tuple((replace(place, radius=_error(place, errors)), share) for place, share in ((nipple, 1.0), (at, -1.0)))
    lowest = None if own[1] is None else float(np.hypot(own[1], hidden))
    over_fold = nipple.point - fold.point, low - fold.point
    names = str(nipple), str(at)
    return _Heights(
        above[0], halves[0], above[1], halves[1], contour, ends, (hidden, lowest), over_fold, (nipple.point, low), names
    )


def _half_between(frame: BodyFrame, sides: Sequence[_Heights], which: int, joint: Joint | None) -> float | None:
    """mm, of the difference of both nipples' (0) or both lowest points' (1) heights; None where it is of one side.

    What the model's folds share cancels, as do a xiphoid that stands for both and most of a lean.
    """
    if len(sides) < 2:
        return None
    up = frame.axes[:, 1]
    ends = [
        (place, sign * share * up)
        for sign, each in zip((1.0, -1.0), sides, strict=True)
        for place, share in each.nipple_ends[which:]
    ]
    lean = LEAN * _across(frame, sides[0].over_fold[which] - sides[1].over_fold[which])
    half = half_width([shared_half_width(ends, joint), *(each.own[which] for each in sides), lean])
    return None if half is None else 1e3 * half


def _fold(
    frame: BodyFrame, nipple: Place, fold: Place, xiphoid: Place | None, errors: Heights
) -> tuple[float, float | None, Place, float]:
    """The fold's level and its error (m), the place that gives it, and the part (m) of it that is not that place's."""
    if fold.source == MODEL and xiphoid is not None:
        over = float(frame.height(nipple.point) - frame.height(xiphoid.point))
        if over < errors.covered_below:
            found = None if xiphoid.radius is None else half_width([errors.hidden_fold, _error(xiphoid, errors)])
            return float(frame.height(xiphoid.point)) + errors.fold_over_xiphoid, found, xiphoid, errors.hidden_fold
    return float(frame.height(fold.point)), _error(fold, errors), fold, 0.0


def _error(place: Place, errors: Heights) -> float | None:
    """The error (m, 90 %) of a place's height: a click's for a picked one, whatever the fit's radius there."""
    if place.radius is None:
        return None
    return errors.picked if place.source == PICKED else place.radius


def _across(frame: BodyFrame, offset: Array) -> float:
    """m of a (3,) m offset at right angles to the body's axis: what a lean turns into height."""
    return float(np.linalg.norm(offset - (offset @ frame.axes[:, 1]) * frame.axes[:, 1]))


def _mm(above: float, half: float | None) -> Value:
    return banded(1e3 * above, None if half is None else 1e3 * half, -np.inf)


def _graded(heights: _Heights) -> Value:
    """The grade, and the grades that the bands leave open; none for a glandular one, which is no degree.

    How far the nipple is over the lowest contour does not depend on where the fold is.
    """
    found = grade(heights.nipple, heights.lowest)
    if heights.nipple_half is None or heights.contour_half is None or found == GLANDULAR:
        return Value(found)
    over = heights.nipple - heights.lowest
    nipples = [heights.nipple + side * heights.nipple_half for side in (-1.0, 1.0)]
    overs = [over + side * heights.contour_half for side in (-1.0, 1.0)]
    open_ones = [grade(nipple, nipple - each) for nipple in nipples for each in overs]
    degrees = [0.0 if each == GLANDULAR else each for each in open_ones]
    return Value(found, min(degrees), max(degrees))
