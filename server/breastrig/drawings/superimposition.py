"""Two drawings on one scan: how far apart are they, shape by shape (the paper's figures 9c and 9f).

Distances are symmetric: from points set evenly along each line to the nearest place of the other line, and back, all
in one heap.  So neither line's own points nor its length decide, and a line that covers only a part of the other
does not look right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.drawings.drawing_file import ScanShape
from breastrig.geometry.curves import resampled

SPACING = 0.001  # m between the points that are measured; the largest distance is known to half of it


@dataclass(frozen=True, eq=False)
class ShapeGap:
    """Two shapes of one name."""

    name: str
    distances: Array  # (M,) m, both directions

    @property
    def mean_mm(self) -> float:
        return 1e3 * float(self.distances.mean())

    @property
    def p95_mm(self) -> float:
        return 1e3 * float(np.percentile(self.distances, 95))

    @property
    def max_mm(self) -> float:
        return 1e3 * float(self.distances.max())


def gaps(first: Sequence[ScanShape], second: Sequence[ScanShape]) -> tuple[ShapeGap, ...]:
    """One for each name that both drawings have, in the first one's order; BadDrawing when there is none."""
    partner = {shape.name: shape for shape in second}
    common = [shape for shape in first if shape.name in partner]
    if not common:
        raise BadDrawing(
            "The two drawings have no shape of the same name; give the shapes that belong together one name."
        )
    return tuple(ShapeGap(shape.name, symmetric_distances(shape, partner[shape.name])) for shape in common)


def symmetric_distances(first: ScanShape, second: ScanShape) -> Array:
    """(M,) m from points along each polyline to the other polyline."""
    points = [resampled(shape.points, SPACING, shape.closed) for shape in (first, second)]
    return np.concatenate([to_polyline(points[0], second), to_polyline(points[1], first)])


def to_polyline(points: Array, line: ScanShape) -> Array:
    """(M,) m from (M, 3) m points to the nearest place of the line."""
    corners = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    if len(corners) == 1:
        return np.asarray(np.linalg.norm(points - corners[0], axis=1))
    best = np.full(len(points), np.inf)
    for start, end in pairwise(corners):  # lines have some hundred corners
        way = end - start
        share = np.clip((points - start) @ way / max(float(way @ way), 1e-30), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - start - share[:, None] * way, axis=1))
    return best
