"""Distances between two drawings on one scan, shape by shape (the paper's figures 9c and 9f).

They are symmetric: from points set evenly along each line to the nearest place of the other line, in both directions,
all taken together.  So neither line's own points nor its length decide, and a line that covers only a part of the other
does not look right.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.geometry.polyline import Polyline, resampled

SPACING = 0.001  # m between the points that are measured; the largest distance is known to half of it


@dataclass(frozen=True, eq=False)
class ShapeGap:
    """The distances between two shapes of one name."""

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


def gaps(first: Sequence[Polyline], second: Sequence[Polyline]) -> tuple[ShapeGap, ...]:
    """The gap of each name that both drawings have, in the first one's order; BadDrawing when there is none."""
    partner = {shape.name: shape for shape in second}
    common = [shape for shape in first if shape.name in partner]
    if not common:
        raise BadDrawing(
            "The two drawings have no shape of the same name; give the shapes that belong together one name."
        )
    return tuple(ShapeGap(shape.name, symmetric_distances(shape, partner[shape.name])) for shape in common)


def symmetric_distances(first: Polyline, second: Polyline) -> Array:
    """(M,) m from points along each polyline to the other polyline."""
    points = [resampled(shape.points, SPACING, shape.closed) for shape in (first, second)]
    return np.concatenate([second.distances(points[0]), first.distances(points[1])])
