"""Points that are far from each other, to stand for all: farthest-point sampling (Gonzalez, 1985)."""

import numpy as np

from breastrig.core.arrays import Array, Integers


def spread_out(points: Array, count: int) -> Integers:
    """(≤ count,) indices of points far from each other (farthest-point sampling)."""
    count = min(count, len(points))
    chosen = np.zeros(count, dtype=np.int64)
    gaps = np.linalg.norm(points - points[0], axis=1)
    for k in range(1, count):
        chosen[k] = int(gaps.argmax())
        gaps = np.minimum(gaps, np.linalg.norm(points - points[chosen[k]], axis=1))
    return chosen
