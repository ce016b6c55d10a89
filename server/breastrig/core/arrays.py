"""Named array types.  Every array in this package is float64 (indices int64) unless its line says otherwise.

The comment beside a field gives shape and unit; `frozen` makes the promise of immutability real.
"""

from functools import reduce
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Booleans: TypeAlias = NDArray[np.bool_]
Complexes: TypeAlias = NDArray[np.complex128]


def frozen(array: Any, dtype: Any = np.float64) -> Any:
    """A read-only C-contiguous copy-if-needed of `array`; a view that others could write through is copied."""
    result = np.ascontiguousarray(array, dtype=dtype)
    if result.flags.writeable:
        if result is array or result.base is not None:
            result = result.copy()
        result.flags.writeable = False
    return result


# NumPy reduces a short last axis row by row, in five times the time that whole columns take; the same bits come out.


def lengths(vectors: Array) -> Array:
    """(M,) Euclidean lengths of (M, D) vectors, for a small D."""
    squares = vectors[:, 0] * vectors[:, 0]
    for axis in range(1, vectors.shape[1]):
        squares += vectors[:, axis] * vectors[:, axis]
    return np.asarray(np.sqrt(squares))


def all_in_row(mask: Booleans) -> Booleans:
    """(M,) of an (M, D) mask, for a small D."""
    return reduce(np.logical_and, mask.T)


def any_in_row(mask: Booleans) -> Booleans:
    """(M,) of an (M, D) mask, for a small D."""
    return reduce(np.logical_or, mask.T)


BITS = 63  # of a number that is not negative


def stable_order(keys: Integers) -> Integers:
    """(N,) as np.argsort(keys, kind="stable") of (N,) whole numbers."""
    room = len(keys).bit_length()
    if not len(keys) or keys.min() < 0 or int(keys.max()).bit_length() + room > BITS:
        return np.argsort(keys, kind="stable")
    packed = keys.astype(np.int64)
    packed <<= room
    packed += np.arange(len(keys))
    packed.sort()
    packed &= (1 << room) - 1
    return packed
