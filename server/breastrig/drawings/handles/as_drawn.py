"""The numbers of a pattern, measured on the lines that it has drawn on one patient.

They may differ from the parameters: a nipple is not moved down, a limb bends with the skin. Page and report show the
measured ones.
"""

from collections.abc import Callable, Sequence

import numpy as np

from breastrig.core.stances import OUTWARDS, sides_of
from breastrig.drawings.clock import FittedSkin, clock_place
from breastrig.drawings.constructions.apart import Apart
from breastrig.drawings.constructions.ellipse import MastectomyEllipse
from breastrig.drawings.constructions.new_fold import middle_of_fold
from breastrig.drawings.constructions.periareolar import Periareolar
from breastrig.drawings.constructions.reduction import Reduction
from breastrig.drawings.constructions.tumour import PickedTumour, Tumour
from breastrig.drawings.constructions.vertical import Vertical
from breastrig.drawings.handles.handle import nearest_on_way, turned
from breastrig.drawings.patterns import Pattern
from breastrig.geometry.polyline import length, point_along
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape

SAME = {"mm": 1.0, "deg": 1.0, "h": 0.05}  # by unit: what is drawn within it is what was asked for
RIM = 8  # points of a circle to which its radius is measured

Numbers = dict[str, float]


def as_drawn(pattern: Pattern, skin: FittedSkin) -> dict[str, dict[str, float]]:
    """{parameter: {side: number}} of every number that the pattern has; BadDrawing where it does not fit."""
    if isinstance(pattern, Apart):
        each = [as_drawn(one, skin) for _, one in pattern.sides]
        return {name: {side: mm for numbers in each for side, mm in numbers[name].items()} for name in each[0]}
    shapes = {shape.name: shape for shape in pattern.drawn(skin)}
    found = {side: _measured(pattern, skin, shapes, side) for side in _sides(pattern, shapes)}
    names = dict.fromkeys(name for numbers in found.values() for name in numbers)
    return {name: {side: numbers[name] for side, numbers in found.items()} for name in names}


def _sides(pattern: Pattern, shapes: dict[str, DrawnShape]) -> tuple[str, ...]:
    if isinstance(pattern, PickedTumour):
        return tuple(name[-1] for name in shapes)
    return tuple(sides_of(getattr(pattern, "side", "both")))


def _measured(pattern: Pattern, skin: FittedSkin, shapes: dict[str, DrawnShape], side: str) -> Numbers:
    match pattern:
        case Reduction():
            return _wise(pattern, skin, shapes, side)
        case Vertical():
            return _vertical(pattern, skin, shapes, side)
        case Periareolar():
            return _rings(skin, shapes, side)
        case MastectomyEllipse():
            return _ellipse(skin, shapes, side)
        case Tumour():
            centre = pattern.centre(skin)
            distance, angle = clock_place(skin, skin.landmark(f"nipple_{side}"), centre)
            hour = pattern.clock if distance < 1e-3 else float(np.degrees(angle)) / 30.0 % 12.0
            clock = hour if hour >= 0.5 else hour + 12.0
            rim = 0.5 * _across(skin, centre, shapes[f"tumour_{side}"].points)
            return {"clock": clock, "distance_mm": 1e3 * distance, "radius_mm": rim}
        case PickedTumour():
            centre = skin.nearest(1e-3 * np.array([[pattern.x_mm, pattern.y_mm, pattern.z_mm]]))
            x, y, z = 1e3 * skin.at(centre)[0]
            rim = 0.5 * _across(skin, centre, shapes[f"tumour_{side}"].points)
            return {"x_mm": float(x), "y_mm": float(y), "z_mm": float(z), "radius_mm": rim}
    return {}


def _wise(pattern: Reduction, skin: FittedSkin, shapes: dict[str, DrawnShape], side: str) -> Numbers:
    breast, cut = pattern.constructed(skin)[side], shapes[f"wise_{side}"]
    lower, arc, arc_end, lower_end = cut.corners
    line = skin.at(cut.points)
    number, middle = middle_of_fold(skin, side)
    down, angle = clock_place(skin, middle, shapes[f"wise_fold_{side}"].points[[number]])
    return {
        "areola_mm": _across(skin, breast.nipple, shapes[f"areola_{side}"].points),
        "limb_mm": 500.0 * (length(line[lower : arc + 1]) + length(line[arc_end : lower_end + 1])),
        "limb_angle_deg": _spread(
            lambda k: clock_place(skin, cut.points[[(arc, arc_end)[k]]], cut.points[[(lower, lower_end)[k]]])[1]
        ),
        "opening_deg": _spread(lambda k: clock_place(skin, breast.new, cut.points[[(arc, arc_end)[k]]])[1]),
        **_new_nipple(skin, side, breast.new, pattern.on_meridian(skin, side, breast.nipple, breast.meridian)),
        "fold_below_mm": -1e3 * down * float(np.sign(np.cos(angle))),
    }


def _vertical(pattern: Vertical, skin: FittedSkin, shapes: dict[str, DrawnShape], side: str) -> Numbers:
    breast, cut = pattern.constructed(skin)[side], shapes[f"vertical_{side}"]
    _, arc_end, lowest = cut.corners
    line = skin.at(cut.points)
    limbs = line[arc_end : lowest + 1], np.concatenate([line[lowest:], line[:1]])
    first, second = (point_along(limb, 0.5 * length(limb)) for limb in limbs)
    return {
        "areola_mm": _across(skin, breast.nipple, shapes[f"areola_{side}"].points),
        "width_mm": 1e3 * float(np.linalg.norm(first - second)),
        "above_fold_mm": 1e3 * nearest_on_way(breast.way, line[lowest])[1],
        **_new_nipple(skin, side, breast.new, pattern.on_meridian(skin, side, breast.nipple, breast.meridian)),
    }


def _new_nipple(skin: FittedSkin, side: str, new: SurfacePoints, on_meridian: SurfacePoints) -> Numbers:
    at, foot = skin.at(new)[0], skin.at(on_meridian)[0]
    aside = skin.geodesics.distance(on_meridian, new)
    outward = np.sign((at - foot) @ (OUTWARDS[side] * skin.axes[:, 0]))
    return {
        "nipple_above_fold_mm": 1e3 * (float(foot @ skin.axes[:, 1]) - skin.height(f"inframammary_fold_{side}")),
        "nipple_outward_mm": 1e3 * float(outward) * aside,
    }


def _rings(skin: FittedSkin, shapes: dict[str, DrawnShape], side: str) -> Numbers:
    nipple, ring = skin.landmark(f"nipple_{side}"), shapes[f"periareolar_{side}"].points
    count = len(ring.faces)  # from 12 o'clock on
    up, *others = (_away(skin, nipple, ring, k) for k in (0, count // 4, count // 2, 3 * count // 4))
    half = float(np.mean(others))
    across = _across(skin, nipple, shapes[f"areola_{side}"].points)
    return {"areola_mm": across, "outer_mm": 2.0 * half, "lift_mm": up - half}


def _ellipse(skin: FittedSkin, shapes: dict[str, DrawnShape], side: str) -> Numbers:
    nipple, rim = skin.landmark(f"nipple_{side}"), shapes[f"mastectomy_{side}"].points
    count = len(rim.faces)  # from one end of the first axis on
    ends = [_away(skin, nipple, rim, k) for k in (0, count // 4, count // 2, 3 * count // 4)]
    _, angle = clock_place(skin, nipple, rim[[0]])
    over = 90.0 - float(np.degrees(OUTWARDS[side] * angle))
    return {"length_mm": ends[0] + ends[2], "width_mm": ends[1] + ends[3], "axis_deg": (over + 90.0) % 180.0 - 90.0}


def _spread(angle_of: Callable[[int], float]) -> float:
    """Degrees between two directions, each seen from straight down."""
    return float(np.degrees(turned(angle_of(0) - np.pi) - turned(angle_of(1) - np.pi)))


def _across(skin: FittedSkin, centre: SurfacePoints, rim: SurfacePoints) -> float:
    """mm along the skin through a circle's centre."""
    chosen = np.unique(np.linspace(0, len(rim.faces) - 1, RIM).astype(int))
    return 2.0 * float(np.mean([_away(skin, centre, rim, int(k)) for k in chosen]))


def _away(skin: FittedSkin, centre: SurfacePoints, line: SurfacePoints, k: int) -> float:
    return 1e3 * skin.geodesics.distance(centre, line[[k]])


def differs(asked: float, drawn: Sequence[float] | float, unit: str) -> bool:
    """Whether a measured number differs from its parameter; 90 and -90 degrees are one axis."""
    off = np.abs(np.asarray(drawn, dtype=np.float64) - asked)
    if unit == "deg":
        off = np.minimum(off, np.abs(180.0 - off))
    if unit == "h":
        off = np.minimum(off, np.abs(12.0 - off))
    return bool((off > SAME.get(unit, 1.0)).any())
