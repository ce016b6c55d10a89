"""The handles of the vertical pattern: new nipple, width at both limbs, their end above the fold, areola."""

from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.vertical import Vertical, VerticalBreast
from breastrig.drawings.handles.areola import areola_handle
from breastrig.drawings.handles.handle import Handle, nearest_on_way, towards
from breastrig.drawings.handles.new_nipple import new_nipple_handle
from breastrig.geometry.polyline import point_along
from breastrig.geometry.surface_points import SurfacePoints

AHEAD_MM = 3.0  # along the way, to see where to it goes


def vertical_handles(pattern: Vertical, skin: FittedSkin) -> list[Handle]:
    """BadDrawing when the pattern does not fit on the breast."""
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
    """Beside the middle of a limb."""
    middle, out = breast.middle(skin), (1.0, -1.0)[k] * breast.across(skin)
    at = skin.at(skin.nearest((middle + 0.5e-3 * pattern.width_mm * out)[None]))[0]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        return {"width_mm": 2e3 * float((skin.at(place)[0] - middle) @ out)}

    return Handle(f"width_{('first', 'second')[k]}_{side}", side, {"width_mm": pattern.width_mm}, at, out, values_at)


def _end(pattern: Vertical, skin: FittedSkin, side: str, breast: VerticalBreast) -> Handle:
    """Where the limbs meet, on the way from the fold to the nipple."""

    def values_at(place: SurfacePoints) -> dict[str, float]:
        return {"above_fold_mm": 1e3 * nearest_on_way(breast.way, skin.at(place)[0])[1]}

    at = skin.at(breast.lowest)[0]
    ahead = point_along(breast.way, 1e-3 * (pattern.above_fold_mm + AHEAD_MM))
    return Handle(f"end_{side}", side, {"above_fold_mm": pattern.above_fold_mm}, at, towards(at, ahead), values_at)
