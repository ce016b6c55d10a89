"""Slices that are missing between others: one is laid from its neighbours, more stay open; both are said."""

import numpy as np
from scipy import ndimage

from breastrig.core.arrays import Booleans, Integers


def between(one: Booleans, other: Booleans) -> Booleans:
    """(R, C) the slice half way between two, whose outline runs half way between theirs."""
    return np.asarray(_depth(one) + _depth(other) > 0.0)


def _depth(inside: Booleans) -> np.ndarray:
    """(R, C) pixels to the outline, negative outside."""
    if not inside.any() or inside.all():
        return np.full(inside.shape, 1e6 if inside.all() else -1e6)
    depth = ndimage.distance_transform_edt(inside) - ndimage.distance_transform_edt(~inside)
    return np.asarray(depth - 0.5 * np.sign(depth))


def runs(missing: Booleans) -> list[tuple[int, int]]:
    """First and last of each run of missing slices that lies between others."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
    pairs: Integers = edges.reshape(-1, 2)
    return [(int(first), int(stop - 1)) for first, stop in pairs if first > 0 and stop < len(missing)]
