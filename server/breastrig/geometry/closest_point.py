"""Exact closest points on triangles and on whole meshes.

One triangle is projected on by the cases of Ericson (Real-Time Collision Detection, 2005, section 5.1.5).  A mesh is
searched with libigl's tree of bounding boxes: branch and bound, so the answer is exact whatever the sizes of the
triangles.  A k-d tree that proposes the nearest centroids is not: where a fan closes a hole, the nearest centroids
belong to small triangles beside the large one that the point lies on.

What libigl 2.6 does that a caller would not expect, and what is done about it here:

* from 1,000 points on it starts as many threads as there are cores, which breaks the rule of one thread a fit: points
  are handed over in smaller portions, which it searches in the caller's thread;
* a triangle whose corners are different points on one line is measured wrongly: it is handed over as its longest edge;
* a point that is not finite, or absurdly far, is answered with whatever the memory held: such points are not asked for;
* it checks neither indices nor coordinates: both are checked first.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import igl
import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, all_in_row
from breastrig.geometry.surface_points import SurfacePoints

PORTION = 999  # points; libigl searches up to 1,000 at once without starting threads
FLAT = 1e-16  # (height / longest edge)² under which a triangle counts as its longest edge, 0.1 nm off on one of 10 mm
FARTHEST = 1e100  # m; beyond it squares overflow


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """The closest points on a mesh to M queries."""

    faces: Integers  # (M,)
    barycentric: Array  # (M, 3)
    points: Array  # (M, 3) m
    distances: Array  # (M,) m

    @property
    def on_mesh(self) -> SurfacePoints:
        """The points as faces and barycentric coordinates, which follow the mesh."""
        return SurfacePoints(self.faces, self.barycentric)


def closest_barycentric(points: Array, corners: Array) -> Array:
    """(M, 3) barycentric coordinates of the point of triangle (M, 3, 3) that is closest to (M, 3) points.

    A triangle without area is the longest of its edges.
    """
    a, b, c = np.ascontiguousarray(corners.transpose(1, 2, 0))  # (3, M) each: sums along M are several times faster
    ab, ac, ap = b - a, c - a, points.T - a

    def dot(u: Array, v: Array) -> Array:
        return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])

    def ratio(top: Array, bottom: Array) -> Array:
        return np.asarray(np.clip(top / np.where(bottom == 0.0, 1.0, bottom), 0.0, 1.0))

    d1, d2 = dot(ab, ap), dot(ac, ap)
    ab2, ac2, abac = dot(ab, ab), dot(ac, ac), dot(ab, ac)
    # projections on the plane, then clamped to the nearest edge or corner where outside; the last one counts
    d3, d4, d5, d6 = d1 - ab2, d2 - abac, d1 - abac, d2 - ac2
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    b_to_c, c_to_b = d4 - d3, d5 - d6
    flat = _flat(np.array([ab2, b_to_c + c_to_b, ac2]), ab, ac)
    total = va + vb + vc
    total[total == 0.0] = 1.0  # only where flat
    at_b, at_c = vb / total, vc / total
    for beyond, weight_b, weight_c in (
        ((va <= 0) & (b_to_c >= 0) & (c_to_b >= 0), None, ratio(b_to_c, b_to_c + c_to_b)),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), 0.0, ratio(d2, ac2)),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), ratio(d1, ab2), 0.0),
        ((d6 >= 0) & (d5 <= d6), 0.0, 1.0),
        ((d3 >= 0) & (d4 <= d3), 1.0, 0.0),
        ((d1 <= 0) & (d2 <= 0), 0.0, 0.0),
    ):
        np.copyto(at_c, weight_c, where=beyond)
        np.copyto(at_b, 1.0 - at_c if weight_b is None else weight_b, where=beyond)
    found = np.stack([1.0 - at_b - at_c, at_b, at_c], axis=1)
    if flat.any():
        found[flat] = _on_longest_edge(points[flat], corners[flat])
    return found


class ClosestPointSearch:
    """Closest points on one fixed mesh of (V, 3) vertices (m) and (F, 3) triangles.

    Raises ValueError when a vertex is not finite or a triangle names one that is not there.
    """

    def __init__(self, vertices: Array, triangles: Integers) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.triangles = np.ascontiguousarray(triangles, dtype=np.int64)
        check_mesh(self.vertices, self.triangles)
        self._elements = _without_flat(self.vertices, self.triangles)
        self._tree = igl.AABB()
        if len(self.triangles):
            self._tree.init(self.vertices, self._elements)

    def query(self, points: Array, reach: float = np.inf) -> ClosestPoints:
        """The closest point for each of (M, 3) points (m).

        Points that are farther than `reach` (m), or not finite, get face -1, distance inf and themselves.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        result = ClosestPoints(
            np.full(len(points), -1, dtype=np.int64),
            np.zeros((len(points), 3)),
            points.copy(),
            np.full(len(points), np.inf),
        )
        for rows, faces, square in self._found(points):
            near = square <= reach * reach
            rows, faces = rows[near], faces[near]
            corners = self.vertices[self.triangles[faces]]
            barycentric = closest_barycentric(points[rows], corners)
            found = np.einsum("mc,mcd->md", barycentric, corners)
            result.faces[rows], result.barycentric[rows], result.points[rows] = faces, barycentric, found
            result.distances[rows] = np.sqrt(((found - points[rows]) ** 2).sum(axis=1))
        return result

    def distances(self, points: Array) -> tuple[Integers, Array]:
        """((M,) triangle, (M,) m) as `query`, in half of its time: without the place on the triangle."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        faces, distances = np.full(len(points), -1, dtype=np.int64), np.full(len(points), np.inf)
        for rows, found, square in self._found(points):
            faces[rows], distances[rows] = found, np.sqrt(square)
        return faces, distances

    def _found(self, points: Array) -> Iterator[tuple[Integers, Integers, Array]]:
        """Portions of the points that can be asked for: their numbers, triangles, and squared distances (m²)."""
        asked = np.flatnonzero(_near(points)) if len(self.triangles) else np.zeros(0, dtype=np.int64)
        for first in range(0, len(asked), PORTION):
            rows = asked[first : first + PORTION]
            square, faces, _ = self._tree.squared_distance(self.vertices, self._elements, points[rows])
            yield rows, faces, square


def check_mesh(vertices: Array, triangles: Integers) -> None:
    """Raises ValueError where arrays are no finite (V, 3) vertices and (F, 3) triangles of them."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not _near(vertices).all():
        raise ValueError("Vertices must be finite and of shape (V, 3).")
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError("Triangles must be of shape (F, 3).")
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        raise ValueError("A triangle names a vertex that is not there.")


def _near(points: Array) -> Booleans:
    """(M,) finite and not absurdly far."""
    return np.asarray(all_in_row(np.abs(points) < FARTHEST))  # nan is not less


def _flat(squares: Array, ab: Array, ac: Array) -> Booleans:
    """(M,) of triangles with (3, M) squared edges, two of them (3, M): no area beside the longest edge."""
    area = sum((ab[i] * ac[j] - ab[j] * ac[i]) ** 2 for i, j in ((1, 2), (2, 0), (0, 1)))
    return np.asarray(area <= FLAT * squares.max(axis=0) ** 2)


def _longest_edges(corners: Array) -> tuple[Array, Integers]:
    """((3, M) squared lengths, (M,) corner at which the longest begins) of the edges of triangles (M, 3, 3)."""
    ends = np.roll(corners, -1, axis=1) - corners
    squares = np.einsum("mci,mci->cm", ends, ends)
    return squares, squares.argmax(axis=0)


def _on_longest_edge(points: Array, corners: Array) -> Array:
    """(M, 3) barycentric coordinates of the closest point of the longest edge."""
    _, first = _longest_edges(corners)
    rows, second = np.arange(len(points)), (first + 1) % 3
    start = corners[rows, first]
    along = corners[rows, second] - start
    square = np.einsum("mi,mi->m", along, along)
    share = np.einsum("mi,mi->m", points - start, along) / np.where(square == 0.0, 1.0, square)
    share = np.clip(share, 0.0, 1.0)
    found = np.zeros((len(points), 3))
    found[rows, second] = share
    found[rows, first] = 1.0 - share
    return found


def _without_flat(vertices: Array, triangles: Integers) -> Integers:
    """(F, 3) the triangles, those without area as their longest edge (a b b), which libigl measures as such."""
    if not len(triangles):
        return triangles
    axes = np.ascontiguousarray(vertices.T)
    a, b, c = (axes.take(corner, axis=1) for corner in np.ascontiguousarray(triangles.T))
    squares = np.array([((v - u) ** 2).sum(axis=0) for u, v in ((a, b), (b, c), (c, a))])
    flat = np.flatnonzero(_flat(squares, b - a, c - a))
    if not len(flat):
        return triangles
    first = squares[:, flat].argmax(axis=0)
    second = (first + 1) % 3
    result = triangles.copy()
    result[flat] = np.stack([triangles[flat, first], triangles[flat, second], triangles[flat, second]], axis=1)
    return result
