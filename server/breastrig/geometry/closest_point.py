"""Exact closest points on triangles, and a search for them with a k-d tree over triangle centroids.

SciPy's tree proposes the k nearest centroids, the exact projection (Ericson, Real-Time Collision Detection,
2005, section 5.1.5) decides.  With k = 4 about 1 % of the answers are more than 0.1 mm off, with 16 none
(80,000 triangles of a body scan), so the fit uses 4 and the report 16.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """Where M queries met the mesh."""

    faces: Integers  # (M,)
    barycentric: Array  # (M, 3)
    points: Array  # (M, 3) m
    distances: Array  # (M,) m


def closest_barycentric(points: Array, corners: Array) -> Array:
    """(M, 3) barycentric coordinates of the point of triangle (M, 3, 3) that is closest to (M, 3) points."""
    a, b, c = np.ascontiguousarray(corners.transpose(1, 2, 0))  # (3, M) each: sums along M are several times faster
    ab, ac, ap = b - a, c - a, points.T - a

    def dot(u: Array, v: Array) -> Array:
        return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])

    def ratio(top: Array, bottom: Array) -> Array:
        return np.asarray(np.clip(top / np.where(np.abs(bottom) < 1e-30, 1.0, bottom), 0.0, 1.0))

    d1, d2 = dot(ab, ap), dot(ac, ap)
    ab2, ac2, abac = dot(ab, ab), dot(ac, ac), dot(ab, ac)
    # projections on the plane, then clamped to the nearest edge or corner where outside; the last one counts
    d3, d4, d5, d6 = d1 - ab2, d2 - abac, d1 - abac, d2 - ac2
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = va + vb + vc
    flat = np.abs(total) < 1e-30
    total[flat] = 1.0
    at_b, at_c = vb / total, vc / total
    at_b[flat] = at_c[flat] = 0.0
    b_to_c, c_to_b = d4 - d3, d5 - d6
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
    return np.stack([1.0 - at_b - at_c, at_b, at_c], axis=1)


class ClosestPointSearch:
    """Closest points on one fixed mesh of (V, 3) vertices (m) and (F, 3) triangles."""

    def __init__(self, vertices: Array, triangles: Integers) -> None:
        self.vertices, self.triangles = vertices, triangles
        self._corners = vertices[triangles]
        a, b, c = self._corners.transpose(1, 0, 2)  # by hand: reductions over three numbers are slow
        centroids = (a + b + c) / 3.0
        arms = self._corners - centroids[:, None]
        spans = np.sqrt(np.einsum("fci,fci->fc", arms, arms)).max(axis=1)
        self.largest_reach = float(np.percentile(spans, 99))  # m, from a centroid to its corners; a few are freaks
        self._tree = cKDTree(centroids, balanced_tree=False, compact_nodes=False)

    def query(self, points: Array, candidates: int = 4, reach: float = np.inf) -> ClosestPoints:
        """The closest point for each of (M, 3) points, the best of `candidates` nearest triangles.

        Points without a centroid within `reach` (m) get face -1 and distance inf: asking for less is faster.
        """
        k = min(candidates, len(self.triangles))
        result = ClosestPoints(
            np.full(len(points), -1, dtype=np.int64),
            np.zeros((len(points), 3)),
            points.copy(),
            np.full(len(points), np.inf),
        )
        _, near = self._tree.query(points, k=k, distance_upper_bound=reach)
        near = np.asarray(near).reshape(len(points), k)
        hit = np.flatnonzero(near[:, 0] < len(self.triangles))
        near = near[hit]
        near = np.where(near < len(self.triangles), near, near[:, :1])  # fewer than k within reach: the first again
        corners = self._corners[near.ravel()]
        barycentric = closest_barycentric(np.repeat(points[hit], k, axis=0), corners)
        found = np.einsum("mc,mcd->md", barycentric, corners).reshape(-1, k, 3)
        gaps = ((found - points[hit][:, None]) ** 2).sum(axis=2)
        best = gaps.argmin(axis=1)
        rows = np.arange(len(hit))
        result.faces[hit] = near[rows, best]
        result.barycentric[hit] = barycentric.reshape(-1, k, 3)[rows, best]
        result.points[hit] = found[rows, best]
        result.distances[hit] = np.sqrt(gaps[rows, best])
        return result
