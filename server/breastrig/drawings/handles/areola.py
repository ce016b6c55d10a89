"""The handle of a circle around the nipple: the areola that is kept, and the lift and the ring around it."""

import numpy as np

from breastrig.core.stances import OUTWARDS
from breastrig.drawings.clock import FittedSkin, on_clock
from breastrig.drawings.handles.handle import Handle, towards
from breastrig.geometry.surface_points import SurfacePoints

OUTSIDE = {side: out * np.pi / 2.0 for side, out in OUTWARDS.items()}  # rad clockwise from 12: laterally


def areola_handle(skin: FittedSkin, side: str, nipple: SurfacePoints, areola_mm: float) -> Handle:
    """On the rim of the areola that is kept, laterally."""
    return across_handle(skin, "areola", "areola_mm", side, nipple, areola_mm, OUTSIDE[side])


def across_handle(
    skin: FittedSkin, name: str, parameter: str, side: str, nipple: SurfacePoints, across_mm: float, angle: float
) -> Handle:
    """At half of `across_mm` from the nipple under an angle (rad, clockwise from 12): twice its distance counts."""
    at = skin.at(on_clock(skin, nipple, 0.5e-3 * across_mm, np.array([angle])))[0]
    return Handle(
        f"{name}_{side}",
        side,
        {parameter: across_mm},
        at,
        towards(skin.at(nipple)[0], at),
        lambda place: {parameter: 2e3 * skin.geodesics.distance(nipple, place)},
    )
