"""Named array types.  Every array in this package is float64 (indices int64) unless its line says otherwise.

The comment beside a field gives shape and unit; `frozen` makes the promise of immutability real.
"""

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
