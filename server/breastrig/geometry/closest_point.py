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
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac = b - a, c - a

    def dot(u: Array, v: Array) -> Array:
        return np.asarray(np.einsum("mi,mi->m", u, v))

    d1, d2 = dot(ab, points - a), dot(ac, points - a)
    ab2, ac2, abac = dot(ab, ab), dot(ac, ac), dot(ab, ac)
    # projections on the plane, then clamped to the nearest edge where outside
    d3, d4, d5, d6 = d1 - ab2, d2 - abac, d1 - abac, d2 - ac2
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2

    def ratio(top: Array, bottom: Array) -> Array:
        return np.asarray(np.clip(top / np.where(np.abs(bottom) < 1e-30, 1.0, bottom), 0.0, 1.0))

    on_ab, on_ac = ratio(d1, ab2), ratio(d2, ac2)
    on_bc = ratio(d4 - d3, (d4 - d3) + (d5 - d6))
    zero, one = np.zeros_like(d1), np.ones_like(d1)
    total = va + vb + vc
    inside = np.stack([va, vb, vc], 1) / np.where(np.abs(total) < 1e-30, 1.0, total)[:, None]
    at_a, at_b, at_c = (np.stack(t, 1) for t in ((one, zero, zero), (zero, one, zero), (zero, zero, one)))
    cases = [
        ((d1 <= 0) & (d2 <= 0), at_a),
        ((d3 >= 0) & (d4 <= d3), at_b),
        ((d6 >= 0) & (d5 <= d6), at_c),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), np.stack([1 - on_ab, on_ab, zero], 1)),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), np.stack([1 - on_ac, zero, on_ac], 1)),
        ((va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0), np.stack([zero, 1 - on_bc, on_bc], 1)),
    ]
    result = np.where((np.abs(total) < 1e-30)[:, None], at_a, inside)
    for condition, value in reversed(cases):
        result = np.where(condition[:, None], value, result)
    return np.asarray(result)


class ClosestPointSearch:
    """Closest points on one fixed mesh of (V, 3) vertices (m) and (F, 3) triangles."""

    def __init__(self, vertices: Array, triangles: Integers) -> None:
        self.vertices, self.triangles = vertices, triangles
        self._corners = vertices[triangles]
        centroids = self._corners.mean(axis=1)
        spans = np.linalg.norm(self._corners - centroids[:, None], axis=2).max(axis=1)
        self.largest_reach = float(np.percentile(spans, 99))  # m, from a centroid to its corners; a few are freaks
        self._tree = cKDTree(centroids, balanced_tree=False, compact_nodes=False)

    def query(self, points: Array, candidates: int = 4, reach: float = np.inf) -> ClosestPoints:
        """The closest point for each of (M, 3) points, the best of `candidates` nearest triangles.

        Points without a centroid within `reach` (m) get face -1 and distance inf: asking for less is faster.
        """
        k = min(candidates, len(self.triangles))
        _, near = self._tree.query(points, k=k, distance_upper_bound=reach)
        near = np.asarray(near).reshape(len(points), k)
        query, column = np.nonzero(near < len(self.triangles))
        faces = near[query, column]
        barycentric = closest_barycentric(points[query], self._corners[faces])
        found = np.einsum("mc,mcd->md", barycentric, self._corners[faces])
        gaps = np.full((len(points), k), np.inf)
        slot = np.zeros((len(points), k), dtype=np.int64)
        gaps[query, column] = np.linalg.norm(found - points[query], axis=1)
        slot[query, column] = np.arange(len(query))
        best = gaps.argmin(axis=1)
        rows = np.arange(len(points))
        distances = gaps[rows, best]
        hit = np.isfinite(distances)
        chosen = slot[rows[hit], best[hit]]
        result = ClosestPoints(
            np.full(len(points), -1, dtype=np.int64), np.zeros((len(points), 3)), points.copy(), distances
        )
        result.faces[hit], result.barycentric[hit], result.points[hit] = (
            faces[chosen],
            barycentric[chosen],
            found[chosen],
        )
        return result
