"""Polygons of any number of corners as triangles, and what is painted on faces or corners as colours of vertices."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers

FEW_CORNERS = "{count} of this file {have} fewer than three corners and {were} left out."


def few_corners(count: int) -> str:
    """The note on how many faces were left out because they are a line, a point or empty."""
    one = count == 1
    return FEW_CORNERS.format(
        count="One face" if one else f"{count:,} faces", have="has" if one else "have", were="was" if one else "were"
    )


def whole_numbers(values: NDArray[Any]) -> Integers:
    """The values as integers; ValueError where one has a fraction or is too large."""
    with np.errstate(all="ignore"):
        found = values.astype(np.int64)
    if not np.array_equal(found, values):
        raise ValueError("no whole number")
    return found


def ranges(starts: Integers, counts: Integers) -> Integers:
    """`counts` numbers from each of the `starts`, one after the other."""
    before = np.cumsum(counts) - counts
    return np.asarray(np.repeat(starts - before, counts) + np.arange(int(counts.sum())))


def fans(counts: Integers) -> tuple[Integers, Integers]:
    """(F, 3) corners, counted through all polygons, of their triangles; and (F,) the polygon of each."""
    each = np.maximum(counts - 2, 0)
    polygons = np.repeat(np.arange(len(counts)), each)
    first = (np.cumsum(counts) - counts)[polygons]
    step = np.arange(len(polygons)) - np.repeat(np.cumsum(each) - each, each)
    return np.column_stack([first, first + step + 1, first + step + 2]), polygons


def strip(corners: Integers) -> Integers:
    """(F, 3) of a strip of triangles: every other one runs the other way round."""
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    faces = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces


def split(faces: Integers, corners: Array) -> tuple[Integers, Integers, Array]:
    """(which vertex each new one was, (F, 3) faces, what each new one has) of (F, 3, k) values of the corners.

    A vertex whose corners differ becomes several.
    """
    rows = np.column_stack([faces.reshape(-1, 1).astype(np.float64), corners.reshape(faces.size, -1)])
    order = np.lexsort(rows.T[::-1])
    starts = np.ones(len(order), np.bool_)
    starts[1:] = (rows[order][1:] != rows[order][:-1]).any(axis=1)
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    first = order[starts]
    return faces.reshape(-1)[first], group.reshape(-1, 3), rows[first, 1:]
