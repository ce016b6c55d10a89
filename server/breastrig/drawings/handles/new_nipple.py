"""The handle of the new nipple: up and down the meridian, never below the nipple that is there, and beside it.

The meridian holds it: a hand that means to go up trembles to the sides.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.handle import Handle
from breastrig.geometry.surface_points import SurfacePoints

ABOVE, OUTWARD = "nipple_above_fold_mm", "nipple_outward_mm"
HOLDS_MM = 5.0  # that it is pulled aside before it leaves the meridian


def new_nipple_handle(skin: FittedSkin, side: str, new: SurfacePoints, meridian: Array, outward_mm: float) -> Handle:
    """`meridian` is (M, 3) m from the collarbone to the nipple, `outward_mm` what is planned beside it."""
    up, outward = skin.axes[:, 1], skin.axes[:, 0] * (1.0 if side == "L" else -1.0)
    fold = float(skin.at(skin.landmark(f"inframammary_fold_{side}"))[0] @ up)
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
        is_held = outward_mm == 0.0 and abs(aside) < HOLDS_MM
        return {ABOVE: above_fold_mm(at), OUTWARD: 0.0 if is_held else aside}

    at = skin.at(new)[0]
    least = {ABOVE: above_fold_mm(meridian[-1])}
    return Handle(f"new_nipple_{side}", side, {ABOVE: above_fold_mm(at), OUTWARD: outward_mm}, at, up, values_at, least)
