"""The handle of the new nipple: up and down the meridian, never below the nipple that is there, and beside it.

The meridian holds it: a hand that means to go up trembles to the sides, and the meridian leans.
"""

from typing import Protocol

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import OUTWARDS
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.handle import Handle
from breastrig.geometry.surface_points import SurfacePoints

ABOVE, OUTWARD = "nipple_above_fold_mm", "nipple_outward_mm"
HOLDS_MM = 5.0  # that it is pulled aside before it leaves the meridian,
HOLDS_SHARE = 0.4  # or so much of how far it is pulled up or down: some twenty degrees


class PlannedNipple(Protocol):
    """A pattern that moves the nipple."""

    @property
    def nipple_above_fold_mm(self) -> float: ...
    @property
    def nipple_outward_mm(self) -> float: ...


def new_nipple_handle(
    skin: FittedSkin, side: str, new: SurfacePoints, meridian: Array, planned: PlannedNipple
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
