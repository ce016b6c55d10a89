"""Places far from the origin, in files that hold single precision.

A float32 has 24 bits: 100 m from the origin it rounds by 0.004 mm, at 10 km by half a millimetre.  Scans in the
coordinates of a room, a site or the Earth come from farther away.  glTF holds nothing finer, but its nodes are moved
by decimal numbers: what is far away is written around a place nearby, and its node moved there.
"""

import numpy as np

from breastrig.core.arrays import Array

EXACT_WITHIN = 100.0  # m from the origin


def far_place(points: Array) -> Array:
    """(3,) whole metres amid the (M, 3) m points when they are too far from the origin; else zeros."""
    if not len(points) or np.abs(points).max() <= EXACT_WITHIN:
        return np.zeros(3)
    return np.asarray(np.round(0.5 * (points.min(axis=0) + points.max(axis=0))))
