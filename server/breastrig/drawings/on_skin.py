"""The greatest distance of a drawn point from the skin of its scan: one limit for all interfaces that take lines."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.units import distance_text
from breastrig.geometry.polyline import Polyline

OFF_THE_SKIN = 0.010  # m; drawn points nearer are moved onto the skin, farther ones are of another scan, frame or unit
MOVED = 0.001  # m; a hand, a pen and the noise of a scan are no nearer, so that less is not worth a word
RUNS = 6  # of points that a sentence names


def check_on_skin(line: Polyline, distances: Array) -> None:
    """Raises BadDrawing where a point that crosses no hole is too far off; `distances` (P,) m from points to skin."""
    off = np.flatnonzero((distances > OFF_THE_SKIN) & ~line.bridged)
    if len(off):
        raise BadDrawing(
            f'Point {off[0] + 1} of "{line.name}" is {distance_text(float(distances[off[0]]))} away from the scan; '
            "draw on the skin, and check that drawing and scan have the same unit and frame."
        )


def moved_onto_skin(line: Polyline, distances: Array) -> str | None:
    """A note on the points that a transfer moves onto the skin first; None where they lie on it.

    `distances` (P,) m as in `check_on_skin`, of points that are near enough.
    """
    off = np.flatnonzero((distances > MOVED) & ~line.bridged)
    if not len(off):
        return None
    points = f"point {_runs((off + 1).tolist())} was" if len(off) == 1 else f"points {_runs((off + 1).tolist())} were"
    most = "by" if len(off) == 1 else "by up to"
    return f'"{line.name}": {points} moved onto the skin, {most} {distance_text(float(distances[off].max()))}.'


def _runs(numbers: Sequence[int]) -> str:
    """Numbers as text, 1 to 3, 7 and 9; those beyond RUNS runs are counted."""
    runs = [[number for _, number in run] for _, run in groupby(enumerate(numbers), lambda each: each[1] - each[0])]
    named = [str(run[0]) if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs[:RUNS]]
    left = sum(map(len, runs[RUNS:]))
    named += [f"{left} more"] if left else []
    return " and ".join(filter(None, [", ".join(named[:-1]), named[-1]]))
