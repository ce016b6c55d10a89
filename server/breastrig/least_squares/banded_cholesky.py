"""Cholesky factors of sparse matrices whose unknowns lie on a surface, numbered so that they form a narrow band.

The unknowns are numbered in waves that go over the surface from one end to the other (Cuthill and McKee, Reducing the
bandwidth of sparse symmetric matrices, 1969).  What is left is a dense band, which LAPACK factors by blocks: for a
torso of 2,500 vertices in 14 ms where SuperLU takes 33 ms.  On larger surfaces the band grows, and SuperLU wins.  SciPy
has the same order in `scipy.sparse.csgraph`, whose import takes ten times as long as it is found here.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.scipy_parts import LinAlgError, lapack

WORK = 3e9  # multiplications of a factorisation, beyond which SuperLU is as fast: about 10,000 vertices


class BandedCholesky:
    """For all symmetric (N, N) matrices with entries at the same places, given column by column."""

    def __init__(self, indptr: Integers, indices: Integers) -> None:
        """indptr: (N + 1,) where each column begins in `indices`, the rows of its entries."""
        self._order = wave_order(indptr, indices)
        count = len(self._order)
        place = np.zeros(count, dtype=np.int64)
        place[self._order] = np.arange(count)
        rows, columns = place[indices], np.repeat(place, np.diff(indptr))
        below = rows - columns
        self.band = int(below.max(initial=0))  # of rows below the diagonal
        self._lower = np.flatnonzero(below >= 0)
        self._places = columns[self._lower] * (self.band + 1) + below[self._lower]

    @property
    def is_narrow(self) -> bool:
        """Whether this is the faster way."""
        return len(self._order) * self.band**2 <= WORK

    def solved(self, data: Array, right: Array) -> Array:
        """(N,) A⁻¹ right for the matrix with these entries; LinAlgError when it is not positive definite."""
        count = len(self._order)
        if not count:
            return right
        band = np.zeros((count, self.band + 1))
        band.ravel()[self._places] = data[self._lower]
        factor, info = lapack.dpbtrf(band.T, lower=1, overwrite_ab=1)
        if info:
            raise LinAlgError("The matrix is not positive definite.")
        result = np.zeros(count)
        result[self._order] = lapack.dpbtrs(factor, right[self._order], lower=1)[0]
        return result


def banded_cholesky(indptr: np.ndarray[Any, Any], indices: np.ndarray[Any, Any]) -> BandedCholesky:
    """As BandedCholesky; the last few are kept, for the surfaces of one model have their entries at the same places."""
    return _of_bytes(indptr.astype(np.int64).tobytes(), indices.astype(np.int64).tobytes())


@lru_cache(maxsize=2)  # as many models as are kept
def _of_bytes(indptr: bytes, indices: bytes) -> BandedCholesky:
    return BandedCholesky(np.frombuffer(indptr, dtype=np.int64), np.frombuffer(indices, dtype=np.int64))


def wave_order(indptr: Integers, indices: Integers) -> Integers:
    """(N,) the unknowns of a symmetric (N, N) matrix, those that share an entry near each other.

    indptr, indices: as those of BandedCholesky.
    """
    degrees = np.diff(indptr)
    seen = np.zeros(len(degrees), dtype=np.bool_)
    order = [np.zeros(0, dtype=np.int64)]
    while not seen.all():  # for each connected part
        left = np.flatnonzero(~seen)
        last = _waves(indptr, indices, degrees, int(left[degrees[left].argmin()]), seen.copy())[-1]
        order += _waves(indptr, indices, degrees, int(last[degrees[last].argmin()]), seen)
    return np.concatenate(order)


def _waves(indptr: Integers, indices: Integers, degrees: Integers, start: int, seen: Booleans) -> list[Integers]:
    """The unknowns that are connected with `start`, by their distance from it; they are marked in (N,) `seen`."""
    seen[start] = True
    waves = [np.array([start])]
    while True:
        front = waves[-1]
        lengths = degrees[front]
        parents = np.repeat(np.arange(len(front)), lengths)
        before = np.cumsum(lengths) - lengths
        reached = indices[np.arange(len(parents)) + (indptr[front] - before)[parents]]
        new = ~seen[reached]
        found, first = np.unique(reached[new], return_index=True)
        if not len(found):
            return waves
        waves.append(found[np.lexsort((degrees[found], parents[new][first]))].astype(np.int64))
        seen[found] = True
