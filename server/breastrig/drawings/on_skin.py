"""How far a drawn point may be off the skin of its scan: one limit for every door by which lines come in."""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.units import distance_text
from breastrig.geometry.polyline import Polyline

OFF_THE_SKIN = 0.010  # m; drawn points nearer are moved onto the skin, farther ones are of another scan, frame or unit


def check_on_skin(line: Polyline, distances: Array) -> None:
    """BadDrawing where a point that crosses no hole is farther off; `distances` (P,) m are the points' to the skin."""
    off = np.flatnonzero((distances > OFF_THE_SKIN) & ~line.bridged)
    if len(off):
        raise BadDrawing(
            f'Point {off[0] + 1} of "{line.name}" is {distance_text(float(distances[off[0]]))} away from the scan; '
            "draw on the skin, and check that drawing and scan have the same unit and frame."
        )
