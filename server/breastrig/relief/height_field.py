"""The skin around one place as heights over a plane, smooth enough to be asked for curvatures.

A depth camera's single triangles say nothing of a navel that is as deep as its noise is high; the mean of some dozen
vertices does.  So the scan's vertices are sorted into pixels over a plane, and heights and counts are smoothed by the
same Gaussian before one is divided by the other (normalised convolution, Knutsson and Westin, 1993): holes are
bridged by what is around them, and how much skin each place rests on is known.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.target import ScanTarget

DEPTH = 0.06  # m before and behind the place; farther is other skin
FACING = 0.3  # cosine between a vertex's normal and the plane's; steeper skin has no single height
LEAST_SKIN = 0.4  # of the usual number of filled pixels around; with less, curvatures are those of a border
FEWEST = 50  # vertices; fewer show no form (7 mm apart they are 60 around a fold)


@dataclass(frozen=True, eq=False)
class HeightField:
    """N x M pixels around a place; row 0 is the upper one, column 0 the left one, as seen from outside."""

    pixel: float  # m
    place: Array  # (3,) m, in the scan's frame, under the middle pixel
    axes: Array  # (3, 3) rows: right, up, outwards; unit vectors in the scan's frame
    counts: Array  # (N, M) vertices
    sums: Array  # (N, M) m, of their heights

    @property
    def right(self) -> Array:
        """(1, M) m from the middle."""
        columns = self.counts.shape[1]
        return np.asarray(self.pixel * (np.arange(columns) - columns // 2)[None, :])

    @property
    def up(self) -> Array:
        """(N, 1) m from the middle."""
        rows = self.counts.shape[0]
        return np.asarray(self.pixel * (rows // 2 - np.arange(rows))[:, None])

    def point(self, right: float, up: float, height: float) -> Array:
        """(3,) m in the scan's frame."""
        return np.asarray(self.place + np.array([right, up, height]) @ self.axes)


@dataclass(frozen=True, eq=False)
class SmoothSkin:
    """A height field seen at one scale."""

    height: Array  # (N, M) m; 0 where nothing is near
    across: Array  # (N, M) 1/m, curvature of the cut from right to left; a hollow's is positive
    along: Array  # (N, M) 1/m, likewise of the cut from up to down
    shown: Booleans  # (N, M) whether the scan shows enough skin there


def height_field(
    target: ScanTarget, place: Array, outwards: Array, up: Array, half: tuple[float, float], pixel: float
) -> HeightField | None:
    """Heights within `half` (m right, m up) of `place` (3,) m, over the plane with normal `outwards` (3,).

    None where the scan shows almost nothing there.
    """
    right = np.cross(up, outwards)
    length = float(np.linalg.norm(right))
    if length < 1e-6:
        return None
    right = right / length
    axes = np.stack([right, np.cross(outwards, right), outwards])
    columns, rows = (round(side / pixel) for side in half)
    found = target.vertex_tree.query_ball_point(place, float(np.hypot(np.hypot(*half), DEPTH)))
    if len(found) < FEWEST:
        return None
    near = np.array(found)
    at = (target.vertices[near] - place) @ axes.T
    column, row = (np.rint(at[:, axis] / pixel).astype(np.int64) for axis in (0, 1))
    kept = (np.abs(column) <= columns) & (np.abs(row) <= rows) & (np.abs(at[:, 2]) < DEPTH)
    kept &= target.normals[near] @ axes[2] > FACING
    if kept.sum() < FEWEST:
        return None
    shape = (2 * rows + 1, 2 * columns + 1)
    cell = (rows - row[kept]) * shape[1] + columns + column[kept]
    counts = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape).astype(np.float64)
    sums = np.bincount(cell, at[kept, 2], minlength=shape[0] * shape[1]).reshape(shape)
    return HeightField(pixel, place, axes, counts, np.asarray(sums))


def smooth_skin(field: HeightField, scale: float) -> SmoothSkin:
    """The field smoothed at a `scale` (m), the standard deviation of the Gaussian."""
    pixel = field.pixel
    rows, columns = (_gaussian(length, scale / pixel) for length in field.counts.shape)
    weight = rows @ field.counts @ columns
    filled = rows @ (field.counts > 0.0) @ columns
    usual = np.median(filled[field.counts > 0.0])
    known = weight > 1e-3 * weight.max()
    total = rows @ field.sums @ columns
    height = np.divide(total, weight, out=np.zeros_like(total), where=known)
    down, rightwards = np.gradient(height, pixel)
    along = np.gradient(down, pixel, axis=0) / (1.0 + down**2) ** 1.5
    across = np.gradient(rightwards, pixel, axis=1) / (1.0 + rightwards**2) ** 1.5
    return SmoothSkin(height, across, along, known & (filled > LEAST_SKIN * usual))


def _gaussian(length: int, sigma: float) -> Array:
    """(length, length), symmetric: the weight of each pixel of a line in every other's sum, nothing beyond its ends.

    Lines are short, so that a product with it costs less than loading SciPy's filters.
    """
    places = np.arange(length)
    weights = np.exp(-0.5 * ((places[:, None] - places) / sigma) ** 2)
    return np.asarray(weights / (sigma * np.sqrt(2.0 * np.pi)))
