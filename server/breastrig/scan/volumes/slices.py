"""Fills single missing slices from their neighbours; longer runs stay open. Both are reported."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Booleans, Integers
from breastrig.scan.volumes.volume import Gap

ALIKE = 0.5  # share that the slices on both sides have in common


def between(one: Booleans, other: Booleans) -> Booleans:
    """(R, C) the slice half way between two, whose outline runs half way between theirs."""
    return np.asarray(_depth(one) + _depth(other) > 0.0)


def _depth(inside: Booleans) -> np.ndarray:
    """(R, C) pixels to the outline, negative outside."""
    if not inside.any() or inside.all():
        return np.full(inside.shape, 1e6 if inside.all() else -1e6)
    depth = ndimage.distance_transform_edt(inside) - ndimage.distance_transform_edt(~inside)
    return np.asarray(depth - 0.5 * np.sign(depth))


def bridged_labels(labels: NDArray[np.uint8], axis: int) -> tuple[int, tuple[Gap, ...]]:
    """Fills single empty slices between similar ones in place, (I, J, K) codes. Returns their number, and longer runs.

    Empty slices between two that do not show the same are no gap in anything.
    """
    along = np.moveaxis(labels, axis, 2)
    filled, gaps = 0, list[Gap]()
    for first, last in runs(np.asarray(~along.any(axis=(0, 1)))):
        one, other = along[:, :, first - 1], along[:, :, last + 1]
        both = np.count_nonzero((one > 0) & (other > 0))
        if both < ALIKE * max(np.count_nonzero(one), np.count_nonzero(other)):
            continue
        if last > first:
            gaps.append(Gap(axis, first, last))
            continue
        filled += 1
        for code in np.argsort(-np.bincount(np.concatenate([one.ravel(), other.ravel()])), kind="stable"):
            if code and ((one == code).any() and (other == code).any()):  # the smaller last
                along[:, :, first][between(one == code, other == code)] = code
    return filled, tuple(gaps)


def gaps_said(gaps: tuple[Gap, ...]) -> tuple[str, ...]:
    """The note on runs of missing slices."""
    if not gaps:
        return ()
    count = sum(gap.last - gap.first + 1 for gap in gaps)
    return (f"{count} slices are missing between others, more than one in a row; the skin is open there.",)


def runs(missing: Booleans) -> list[tuple[int, int]]:
    """First and last of each run of missing slices that lies between others."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
    pairs: Integers = edges.reshape(-1, 2)
    return [(int(first), int(stop - 1)) for first, stop in pairs if first > 0 and stop < len(missing)]
