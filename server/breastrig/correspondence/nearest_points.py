"""The nearest of a few hundred or thousand points to each of many places, by comparing all with all.

|a − b|² = |a|² − 2 a·b + |b|² makes of all comparisons one matrix product in single precision; for so few points that
is faster than any tree: 0.13 s instead of 0.19 s for the 97,000 places of one scan's rigid tries, in six dimensions.
The distance is then computed in double precision.  Points of which one is nearer by less than rounding, about 1 µm for
bodies, may be taken one for the other.
"""

import numpy as np

from breastrig.core.arrays import Array, Integers

CELLS = 100_000  # comparisons at once, 0.4 MB: they stay in the processor's cache; four times as many take half again


class NearestPoints:
    """Among fixed (N, D) points, N >= 1."""

    def __init__(self, points: Array) -> None:
        self.points = points
        self._centre = points.mean(axis=0)  # near the origin single precision is finest
        centred = points - self._centre
        products = np.concatenate([-2.0 * centred.T, (centred * centred).sum(axis=1)[None]])
        self._products = products.astype(np.float32)  # (D + 1, N)

    def query(self, places: Array, reach: float) -> tuple[Array, Integers]:
        """Distance and index of the nearest to each of (..., D) places, both (...).

        Where none is nearer than `reach` the distance is inf and the index 0.
        """
        flat = places.reshape(-1, places.shape[-1])
        asked = np.ones((len(flat), len(self._products)), dtype=np.float32)
        np.subtract(flat, self._centre, out=asked[:, :-1], casting="same_kind")
        nearest = np.zeros(len(flat), dtype=np.int64)
        rows = max(1, CELLS // len(self.points))
        table = np.zeros((rows, len(self.points)), dtype=np.float32)
        for first in range(0, len(flat), rows):
            part = asked[first : first + rows]
            compared = table[: len(part)]
            np.matmul(part, self._products, out=compared)
            compared.argmin(axis=1, out=nearest[first : first + rows])
        gaps = self.points.take(nearest, axis=0)
        gaps -= flat
        distances = np.sqrt(np.einsum("md,md->m", gaps, gaps))
        beyond = ~(distances < reach)
        distances[beyond], nearest[beyond] = np.inf, 0
        return distances.reshape(places.shape[:-1]), nearest.reshape(places.shape[:-1])
