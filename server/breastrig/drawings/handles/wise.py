"""The handles of the Wise pattern: new nipple, ends and angle of the limbs, opening of the keyhole, areola, fold.

The new nipple is not moved sideways, off the meridian: that has no parameter.
"""

import numpy as np

from breastrig.drawings.clock import FittedSkin, clock_place
from breastrig.drawings.constructions.new_fold import middle_of_fold
from breastrig.drawings.constructions.reduction import Reduction, WiseBreast, ends
from breastrig.drawings.handles.areola import areola_handle
from breastrig.drawings.handles.handle import Handle, towards, turned
from breastrig.drawings.handles.new_nipple import new_nipple_handle
from breastrig.geometry.polyline import length, point_along
from breastrig.geometry.surface_points import SurfacePoints

SIDEWAYS = ("first", "second")  # what the observer sees on his left comes first


def wise_handles(pattern: Reduction, skin: FittedSkin) -> list[Handle]:
    """BadDrawing when the pattern does not fit on the breast."""
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
    """At its lower end: its length."""
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
    """At half of a limb: how far it turns away from straight down."""
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
    """At an end of the keyhole: the angle at the new nipple."""
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
    """At the new fold below the middle of her own: how far down the skin."""
    number, middle = middle_of_fold(skin, side)
    here = skin.at(breast.fold)[number]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        distance, angle = clock_place(skin, middle, place)
        return {"fold_below_mm": -1e3 * distance * float(np.cos(angle))}

    return Handle(f"fold_{side}", side, {"fold_below_mm": pattern.fold_below_mm}, here, -skin.axes[:, 1], values_at)
