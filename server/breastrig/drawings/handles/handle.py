"""A handle: a place of a pattern on the skin that can be dragged, and the parameter that follows it.

It inverts a construction for one parameter: the pattern computes the handle's place, and the handle computes the
parameter for which the pattern comes to a given place. All else about the place is ignored.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import OUTWARDS
from breastrig.drawings.clock import FittedSkin, on_clock
from breastrig.geometry.surface_points import SurfacePoints

Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Handle:
    """A handle on one side of a pattern."""

    name: str  # unique in the pattern: new_nipple_L
    side: str  # L or R
    values: Values  # of the parameters that it stands for, as they are here
    at: Array  # (3,) m on the fitted skin
    grows: Array  # (3,) unit, where to the first of them grows; (0, 0, 0) where that has no one direction
    values_at: Callable[[SurfacePoints], Values]  # as they must be for the handle to come there
    least: Values | None = None  # where the construction itself ends before the parameter's own limit


def towards(start: Array, end: Array) -> Array:
    """(3,) unit from one (3,) m place to another; zeros where they are one."""
    step = end - start
    size = float(np.linalg.norm(step))
    return np.asarray(step / size if size > 0.0 else np.zeros(3))


def nearest_on_way(way: Array, place: Array) -> tuple[Array, float]:
    """The point of a (M, 3) m polyline next to a (3,) m place, and how many m along the line that is."""
    steps = np.diff(way, axis=0)
    squares = np.maximum(np.einsum("mi,mi->m", steps, steps), 1e-300)
    shares = np.clip(np.einsum("mi,mi->m", place - way[:-1], steps) / squares, 0.0, 1.0)
    feet = way[:-1] + shares[:, None] * steps
    k = int(np.linalg.norm(feet - place, axis=1).argmin())
    lengths = np.sqrt(squares)
    return feet[k], float(lengths[:k].sum() + shares[k] * lengths[k])


def turned(angle: float) -> float:
    """rad, the same direction between -π and π."""
    return float(np.angle(np.exp(1j * angle)))


OUTSIDE = {side: out * np.pi / 2.0 for side, out in OUTWARDS.items()}  # rad clockwise from 12: laterally


def areola_handle(skin: FittedSkin, side: str, nipple: SurfacePoints, areola_mm: float) -> Handle:
    """The handle on the lateral rim of the areola that is kept."""
    return across_handle(skin, "areola", "areola_mm", side, nipple, areola_mm, OUTSIDE[side])


def across_handle(
    skin: FittedSkin, name: str, parameter: str, side: str, nipple: SurfacePoints, across_mm: float, angle: float
) -> Handle:
    """The handle at half of `across_mm` from the nipple under an angle (rad, clockwise from 12): a diameter."""
    at = skin.at(on_clock(skin, nipple, 0.5e-3 * across_mm, np.array([angle])))[0]
    return Handle(
        f"{name}_{side}",
        side,
        {parameter: across_mm},
        at,
        towards(skin.at(nipple)[0], at),
        lambda place: {parameter: 2e3 * skin.geodesics.distance(nipple, place)},
    )
