"""How far a breast hangs: its nipple and its lowest point above or below the fold, and Regnault's grade of ptosis.

Regnault 1976 (Clin Plast Surg 3:193): the nipple against the fold's level while the patient stands.  The limits in
millimetres are the usual reading of the grades:

    I      at the fold or at most 10 mm below it
    II     10 to 30 mm below it, and still above the breast's lowest contour
    III    more than 30 mm below it, or below it and at the lowest contour
    glandular (pseudoptosis): the nipple above the fold, the breast's lowest point well below it

Heights are along the body's own axis (body_frame.py): a scan does not say where the ground is.  A patient who lies has
no ptosis, so these rows are there for a standing one only.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.report.bands import half_width
from breastrig.report.body_frame import BodyFrame
from breastrig.report.stance import Place, Stance
from breastrig.report.table import Row, Value
from breastrig.report.volume import vertices_within

STANDING = "standing"
SLIGHT, MODERATE = 0.010, 0.030  # m of the nipple below the fold: Regnault's I and II end there
AT_CONTOUR = 0.010  # m of the nipple above the breast's lowest point: it is at the lowest contour
GLANDULAR_DROP = 0.020  # m of the lowest point below the fold; a breast that hangs over its fold by less is usual
LEAN = 0.05  # rad; nine of ten body axes of warped standing bodies are within it of the true upright
GLANDULAR = 4.0  # among the grades 0 (none) to 3
SIDES = {"L": "left", "R": "right"}
OUTLINE = "model inside its breast base outline"


@dataclass(frozen=True, eq=False)
class _Heights:
    """One breast, m."""

    nipple: float  # above the fold
    nipple_half: float | None  # of its band
    lowest: float  # above the fold; below zero where the breast hangs over it
    lowest_half: float | None


def grade(nipple: float, lowest: float) -> float:
    """0 none, 1 to 3 as Regnault's I to III, 4 glandular; the heights above the fold in m."""
    if nipple >= 0.0:
        return GLANDULAR if lowest <= -GLANDULAR_DROP else 0.0
    if nipple >= -SLIGHT:
        return 1.0
    return 2.0 if nipple >= -MODERATE and nipple - lowest > AT_CONTOUR else 3.0


def ptosis(stance: Stance, frame: BodyFrame, known: Mapping[str, Place]) -> Iterator[Row]:
    """Three rows for a standing patient whose rig has nipples, folds and outlines of the breasts; else none."""
    ends = {side: (known.get(f"nipple_{side}"), known.get(f"inframammary_fold_{side}")) for side in SIDES}
    insides = {side: vertices_within(stance.rig, side) for side in SIDES}
    if stance.name != STANDING:
        return
    sides: dict[str, _Heights] = {}
    nipples: dict[str, Array] = {}
    lowest: dict[str, Array] = {}
    names: list[str] = []
    for side, (nipple, fold) in ends.items():
        inside = insides[side]
        if nipple is None or fold is None or inside is None:
            return
        skin = stance.vertices[inside]
        low = skin[frame.height(skin).argmin()]
        level = float(frame.height(fold.point))
        above = [float(frame.height(point)) - level for point in (nipple.point, low)]
        halves = [
            half_width([radius, fold.radius, LEAN * _across(frame, point - fold.point)])
            for point, radius in ((nipple.point, nipple.radius), (low, stance.radius_at(low[None])))
        ]
        sides[side] = _Heights(above[0], halves[0], above[1], halves[1])
        nipples[SIDES[side]] = np.stack([nipple.point, nipple.point - above[0] * frame.axes[:, 1]])
        lowest[SIDES[side]] = np.stack([low, low - above[1] * frame.axes[:, 1]])
        names += [str(nipple), str(fold)]
    left, right = sides["L"], sides["R"]
    landmarks = tuple(dict.fromkeys(names))
    folds = tuple(name for name in landmarks if name.startswith("inframammary_fold"))
    how = "along the body's own axis, above the level of the fold's lowest point; below it less than zero"
    yield Row(
        "nipple_above_fold", "Nipple above fold", "in height", "mm",
        _mm(left.nipple, left.nipple_half), _mm(right.nipple, right.nipple_half), None, landmarks, how, nipples,
    )  # fmt: skip
    yield Row(
        "lowest_point_above_fold", "Lowest point above fold", "in height", "mm",
        _mm(left.lowest, left.lowest_half), _mm(right.lowest, right.lowest_half), None,
        (*folds, OUTLINE), how, lowest,
    )  # fmt: skip
    how = (
        "Regnault: I nipple at the fold or up to 10 mm below, II 10 to 30 mm, III more or at the lowest contour; "
        "glandular: nipple above the fold, lowest point 20 mm and more below it"
    )
    yield Row(
        "ptosis", "Ptosis (Regnault)", "grade", "grade", _graded(left), _graded(right), None,
        (*landmarks, OUTLINE), how, nipples,
    )  # fmt: skip


def _across(frame: BodyFrame, offset: Array) -> float:
    """m of a (3,) m offset at right angles to the body's axis: what a lean turns into height."""
    return float(np.linalg.norm(offset - (offset @ frame.axes[:, 1]) * frame.axes[:, 1]))


def _mm(above: float, half: float | None) -> Value:
    ends = (None, None) if half is None else (1e3 * (above - half), 1e3 * (above + half))
    return Value(1e3 * above, *ends)


def _graded(heights: _Heights) -> Value:
    """The grade, and the grades that the nipple's band leaves open; none for a glandular one, which is no degree."""
    found = grade(heights.nipple, heights.lowest)
    if heights.nipple_half is None or found == GLANDULAR:
        return Value(found)
    ends = [grade(heights.nipple + side * heights.nipple_half, heights.lowest) for side in (1.0, -1.0)]
    return Value(found, *(0.0 if end == GLANDULAR else end for end in ends))
