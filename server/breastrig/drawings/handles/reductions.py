"""The handles of both reductions: the new nipple, then those of the Wise pattern and of the vertical one.

The new nipple goes up and down the meridian, never below the nipple that is there, and beside it.  The meridian holds
it: a hand that means to go up trembles to the sides, and the meridian leans.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import OUTWARDS
from breastrig.drawings.clock import FittedSkin, clock_place
from breastrig.drawings.constructions.new_fold import middle_of_fold
from breastrig.drawings.constructions.reduction import Reduction, WiseBreast, ends
from breastrig.drawings.constructions.vertical import Vertical, VerticalBreast
from breastrig.drawings.handles.handle import Handle, areola_handle, nearest_on_way, towards, turned
from breastrig.geometry.polyline import length, point_along
from breastrig.geometry.surface_points import SurfacePoints

ABOVE, OUTWARD = "nipple_above_fold_mm", "nipple_outward_mm"
HOLDS_MM = 5.0  # that it is pulled aside before it leaves the meridian,
HOLDS_SHARE = 0.4  # or so much of how far it is pulled up or down: some twenty degrees


def new_nipple_handle(
    skin: FittedSkin, side: str, new: SurfacePoints, meridian: Array, planned: Reduction | Vertical
) -> Handle:
    """`meridian` is (M, 3) m from the collarbone to the nipple; `new` is where the nipple is planned."""
    up, outward = skin.axes[:, 1], OUTWARDS[side] * skin.axes[:, 0]
    fold = skin.height(f"inframammary_fold_{side}")
    heights = meridian @ up
    order = np.argsort(heights, kind="stable")

    def above_fold_mm(place: Array) -> float:
        return 1e3 * (float(place @ up) - fold)

    def values_at(place: SurfacePoints) -> dict[str, float]:
        at = skin.at(place)[0]
        on_meridian = np.array([np.interp(at @ up, heights[order], meridian[order, axis]) for axis in range(3)])
        across = at - on_meridian - ((at - on_meridian) @ up) * up
        if at @ up < heights[order[0]]:  # below the nipple: only what is to the side counts
            across = (across @ outward) * outward
        aside = 1e3 * float(np.linalg.norm(across) * np.sign(across @ outward))
        above = above_fold_mm(at)
        holds = max(HOLDS_MM, HOLDS_SHARE * abs(above - values[ABOVE]))
        return {ABOVE: above, OUTWARD: 0.0 if values[OUTWARD] == 0.0 and abs(aside) < holds else aside}

    least = above_fold_mm(meridian[-1])
    values = {ABOVE: max(planned.nipple_above_fold_mm, least), OUTWARD: planned.nipple_outward_mm}
    return Handle(f"new_nipple_{side}", side, values, skin.at(new)[0], up, values_at, {ABOVE: least})


SIDEWAYS = ("first", "second")  # what the observer sees on his left comes first


def wise_handles(pattern: Reduction, skin: FittedSkin) -> list[Handle]:
    """The handles of the Wise pattern; BadDrawing when it does not fit on the breast."""
    found = []
    for side, breast in pattern.constructed(skin).items():
        found += [
            new_nipple_handle(skin, side, breast.new, breast.meridian, pattern),
            areola_handle(skin, side, breast.nipple, pattern.areola_mm),
            *(_limb(skin, side, breast, k) for k in (0, 1)),
            *(_angle(pattern, skin, side, breast, k) for k in (0, 1)),
            *(_opening(pattern, skin, side, breast, k) for k in (0, 1)),
            _fold(pattern, skin, side, breast),
        ]
    return found


def _limb(skin: FittedSkin, side: str, breast: WiseBreast, k: int) -> Handle:
    """The handle at a limb's lower end: its length."""
    start, at = ends(breast.arc)[[k]], skin.at(breast.lower)[k]
    return Handle(
        f"limb_{SIDEWAYS[k]}_{side}",
        side,
        {"limb_mm": 1e3 * length(breast.limbs[k])},
        at,
        towards(skin.at(start)[0], at),
        lambda place: {"limb_mm": 1e3 * skin.geodesics.distance(start, place)},
    )


def _angle(pattern: Reduction, skin: FittedSkin, side: str, breast: WiseBreast, k: int) -> Handle:
    """The handle at half of a limb: its angle from straight down."""
    start, turn = ends(breast.arc)[[k]], (1.0, -1.0)[k]
    middles = [point_along(limb, 0.5 * length(limb)) for limb in breast.limbs]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        _, angle = clock_place(skin, start, place)
        return {"limb_angle_deg": 2.0 * float(np.degrees(turn * turned(angle - np.pi)))}

    return Handle(
        f"angle_{SIDEWAYS[k]}_{side}",
        side,
        {"limb_angle_deg": pattern.limb_angle_deg},
        middles[k],
        towards(middles[1 - k], middles[k]),
        values_at,
    )


def _opening(pattern: Reduction, skin: FittedSkin, side: str, breast: WiseBreast, k: int) -> Handle:
    """The handle at an end of the keyhole: the angle at the new nipple."""
    at, turn = skin.at(ends(breast.arc)), (1.0, -1.0)[k]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        _, angle = clock_place(skin, breast.new, place)
        return {"opening_deg": 2.0 * float(np.degrees(turn * turned(angle - np.pi)))}

    return Handle(
        f"opening_{SIDEWAYS[k]}_{side}",
        side,
        {"opening_deg": pattern.opening_deg},
        at[k],
        towards(at[1 - k], at[k]),
        values_at,
    )


def _fold(pattern: Reduction, skin: FittedSkin, side: str, breast: WiseBreast) -> Handle:
    """The handle at the new fold, below the middle of the patient's own: the distance down the skin."""
    number, middle = middle_of_fold(skin, side)
    here = skin.at(breast.fold)[number]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        distance, angle = clock_place(skin, middle, place)
        return {"fold_below_mm": -1e3 * distance * float(np.cos(angle))}

    return Handle(f"fold_{side}", side, {"fold_below_mm": pattern.fold_below_mm}, here, -skin.axes[:, 1], values_at)


AHEAD_MM = 3.0  # along the way, to see where to it goes


def vertical_handles(pattern: Vertical, skin: FittedSkin) -> list[Handle]:
    """The handles of the vertical pattern; BadDrawing when it does not fit on the breast."""
    found = []
    for side, breast in pattern.constructed(skin).items():
        found += [
            new_nipple_handle(skin, side, breast.new, breast.meridian, pattern),
            areola_handle(skin, side, breast.nipple, pattern.areola_mm),
            _end(pattern, skin, side, breast),
            *(_width(pattern, skin, side, breast, k) for k in (0, 1)),
        ]
    return found


def _width(pattern: Vertical, skin: FittedSkin, side: str, breast: VerticalBreast, k: int) -> Handle:
    """The handle beside the middle of a limb."""
    middle, out = breast.middle(skin), (1.0, -1.0)[k] * breast.across(skin)
    at = skin.at(skin.nearest((middle + 0.5e-3 * pattern.width_mm * out)[None]))[0]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        return {"width_mm": 2e3 * float((skin.at(place)[0] - middle) @ out)}

    return Handle(f"width_{('first', 'second')[k]}_{side}", side, {"width_mm": pattern.width_mm}, at, out, values_at)


def _end(pattern: Vertical, skin: FittedSkin, side: str, breast: VerticalBreast) -> Handle:
    """The handle where the limbs meet, between fold and nipple."""

    def values_at(place: SurfacePoints) -> dict[str, float]:
        return {"above_fold_mm": 1e3 * nearest_on_way(breast.way, skin.at(place)[0])[1]}

    at = skin.at(breast.lowest)[0]
    ahead = point_along(breast.way, 1e-3 * (pattern.above_fold_mm + AHEAD_MM))
    return Handle(f"end_{side}", side, {"above_fold_mm": pattern.above_fold_mm}, at, towards(at, ahead), values_at)
