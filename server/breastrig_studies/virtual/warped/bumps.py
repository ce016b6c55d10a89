"""A smooth random warp: a few Gaussian bumps of 80-250 mm around points of the skin, each in a direction of its own."""

import numpy as np

from breastrig.core.arrays import Array


def bump_shift(vertices: Array, bumps: tuple[tuple[float, ...], ...]) -> Array:
    """(V, 3) m of the bumps, each (which vertex as a share of all, length m, x, y, z m).

    The length is from one flank of the bell to the other: twice its standard deviation.
    """
    shift = np.zeros_like(vertices)
    for share, length, *size in bumps:
        centre = vertices[min(int(share * len(vertices)), len(vertices) - 1)]
        square = ((vertices - centre) ** 2).sum(axis=1)
        shift += np.exp(-2.0 * square / length**2)[:, None] * np.array(size)
    return shift
