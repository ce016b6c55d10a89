"""Sorting whole numbers without losing whose they are: each is packed with its place into one, and these are sorted.

NumPy sorts plain numbers with the processor's widest registers, but not their places beside them: for the 180,000 edges
of a scan this takes 0.9 ms instead of 13.
"""

import numpy as np

from breastrig.core.arrays import Integers

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
