"""The handle of the new nipple: up and down the meridian, never below the nipple that is there."""

from breastrig.core.arrays import Array
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.handle import Handle, nearest_on_way
from breastrig.geometry.surface_points import SurfacePoints

PARAMETER = "nipple_above_fold_mm"


def new_nipple_handle(skin: FittedSkin, side: str, new: SurfacePoints, meridian: Array) -> Handle:
    """`meridian` is (M, 3) m from the collarbone to the nipple."""
    up = skin.axes[:, 1]
    fold = float(skin.at(skin.landmark(f"inframammary_fold_{side}"))[0] @ up)

    def above_fold_mm(place: Array) -> float:
        return 1e3 * (float(place @ up) - fold)

    def values_at(place: SurfacePoints) -> dict[str, float]:
        on_meridian, _ = nearest_on_way(meridian, skin.at(place)[0])
        return {PARAMETER: above_fold_mm(on_meridian)}

    at = skin.at(new)[0]
    least = {PARAMETER: above_fold_mm(meridian[-1])}
    return Handle(f"new_nipple_{side}", side, {PARAMETER: above_fold_mm(at)}, at, up, values_at, least)
