"""Clouds of points as plain rows of numbers (.xyz, .asc, .pts, .txt): x y z, then colours or a normal or nothing.

Nothing in such a file says what its columns are, so they are told apart by their numbers: three whole ones from 0 to
255 are a colour, three that make a unit vector are a normal, and one that is left over (an intensity) is passed by.
"""

import warnings

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import number_rows
from breastrig.scan.limits import POINTS
from breastrig.scan.piece import PointCloud

UNIT = 0.02  # that the length of a normal may differ from one: such files are rounded
DAMAGED = "The rows of this point file are not all alike, as in one that was cut off; export it again."


def text_points(data: bytes) -> PointCloud:
    """The points of such a file.  BadScan or TooLarge with a sentence."""
    lines = number_rows(data)
    if len(lines[0].split()) == 1:
        lines = lines[1:]
    if len(lines) > POINTS:
        raise TooLarge(f"This scan has more than the {POINTS:,} points allowed; thin it out first.")
    width = len(lines[0].split())
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            numbers = np.fromstring(b" ".join(lines).decode("latin-1"), np.float64, sep=" ")
        rows = numbers.reshape(len(lines), width)
    except (ValueError, DeprecationWarning) as error:
        raise BadScan(DAMAGED) from error
    normals = colours = None
    for first in range(width - 3, 2, -1):
        three = rows[:, first : first + 3]
        if colours is None and _are_colours(three):
            colours = three.astype(np.uint8)
        elif normals is None and _are_normals(three):
            normals = three
    return PointCloud(rows[:, :3], normals, colours, None)


def _are_colours(three: Array) -> bool:
    return bool((three == np.round(three)).all() and three.min() >= 0.0 and 1.0 < three.max() <= 255.0)


def _are_normals(three: Array) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(np.linalg.norm(three, axis=1) - 1.0) < UNIT).mean() > 0.99)
