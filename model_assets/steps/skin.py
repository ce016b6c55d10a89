"""Questions about the skin of one mesh: where a ray meets it, where its profiles are hollow, how a line lies on it."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.geometry.closest_point import closest_barycentric
from breastrig.geometry.surface_points import SurfacePoints
from steps.source import Array, Integers


@dataclass(frozen=True, eq=False)
class Hits:
    """Where one ray meets the mesh, in order along the ray."""

    faces: Integers  # (H,)
    barycentric: Array  # (H, 3)
    points: Array  # (H, 3) m


class Skin:
    """A mesh (V, 3) m with (F, 3) triangles, asked one question at a time."""

    def __init__(self, vertices: Array, triangles: Integers) -> None:
        self.vertices, self.triangles = vertices, triangles
        self._corners = vertices[triangles]
        a, b, c = self._corners.transpose(1, 0, 2)
        self._tree = cKDTree((a + b + c) / 3.0, balanced_tree=False, compact_nodes=False)
        directed = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
        codes = np.unique(directed.min(axis=1) * len(vertices) + directed.max(axis=1))
        self._edges = np.stack([codes // len(vertices), codes % len(vertices)], axis=1)
        self._a = vertices[triangles[:, 0]]
        self._u = vertices[triangles[:, 1]] - self._a
        self._w = vertices[triangles[:, 2]] - self._a

    def ray(self, origin: Array, direction: Array) -> Hits:
        """All meetings in front of the origin (Möller and Trumbore 1997)."""
        p = np.cross(direction, self._w)
        det = (self._u * p).sum(1)
        safe = np.where(np.abs(det) > 1e-18, det, 1.0)
        offset = origin - self._a
        s = (offset * p).sum(1) / safe
        q = np.cross(offset, self._u)
        t = (direction * q).sum(1) / safe
        along = (self._w * q).sum(1) / safe
        found = np.flatnonzero((np.abs(det) > 1e-18) & (s >= -1e-6) & (t >= -1e-6) & (s + t <= 1 + 1e-6) & (along > 0))
        found = found[np.argsort(along[found], kind="stable")]
        barycentric = np.stack([1 - s - t, s, t], axis=1)[found].clip(0.0, 1.0)
        barycentric /= barycentric.sum(axis=1, keepdims=True)
        return Hits(found, barycentric, origin + along[found, None] * direction)

    def nearest(self, points: Array) -> SurfacePoints:
        """The skin's closest points to (M, 3) points.

        Among the 32 nearest centroids, which is right on the model's even triangles.  A tip or the midline belongs to
        several of them: the first in this order is taken, as whoever kept a fit knows the model by its bytes.
        """
        _, near = self._tree.query(points, k=32)
        corners = self._corners[near]
        share = closest_barycentric(np.repeat(points, 32, axis=0), corners.reshape(-1, 3, 3)).reshape(-1, 32, 3)
        gaps = ((np.einsum("mkc,mkcd->mkd", share, corners) - points[:, None]) ** 2).sum(axis=2)
        best, rows = gaps.argmin(axis=1), np.arange(len(points))
        share = np.round(share[rows, best].clip(0.0, 1.0), 7)
        return SurfacePoints(near[rows, best], share / share.sum(axis=1, keepdims=True))

    def nearest_on_midline(self, points: Array) -> SurfacePoints:
        """The closest points of the mesh's edges in the plane x = 0 to (M, 3) points: exactly in the middle."""
        t = self.triangles
        faces, corners = [], []
        for i in range(3):
            j = (i + 1) % 3
            both = (np.abs(self.vertices[t[:, [i, j]], 0]) < 1e-12).all(axis=1)
            faces.append(np.flatnonzero(both))
            corners.append(np.tile([i, j], (int(both.sum()), 1)))
        face, corner = np.concatenate(faces), np.concatenate(corners)
        a, b = (self.vertices[t[face, corner[:, k]]] for k in (0, 1))
        along = np.einsum("mi,ei->me", points, b - a) - np.einsum("ei,ei->e", a, b - a)
        share = np.clip(along / ((b - a) ** 2).sum(axis=1), 0.0, 1.0)
        gap = np.linalg.norm(a + share[:, :, None] * (b - a) - points[:, None, :], axis=2)
        best = gap.argmin(axis=1)
        barycentric = np.zeros((len(points), 3))
        rows = np.arange(len(points))
        part = np.round(share[rows, best], 7)
        barycentric[rows, corner[best, 0]] = 1.0 - part
        barycentric[rows, corner[best, 1]] = part
        return SurfacePoints(face[best], barycentric)

    def at(self, points: SurfacePoints) -> Array:
        """(M, 3) m."""
        return points.positions(self.vertices, self.triangles)

    def sagittal_cut(self, x: float) -> Array:
        """(M, 3) m: all points where mesh edges cross the plane of this x, unordered."""
        a, b = self.vertices[self._edges[:, 0]], self.vertices[self._edges[:, 1]]
        da, db = a[:, 0] - x, b[:, 0] - x
        crossing = (da * db < 0) | (da == 0)
        share = (da[crossing] / np.where(da == db, 1.0, da - db)[crossing])[:, None]
        return np.asarray(a[crossing] + share * (b[crossing] - a[crossing]))

    def line(self, anchors: Array, closed: bool, spacing: float, rounds: int = 30) -> SurfacePoints:
        """A smooth line on the skin through (near) the (A, 3) anchors, evenly spaced by about `spacing` (m)."""
        path = np.concatenate([anchors, anchors[:1]]) if closed else anchors
        points = self.at(self.nearest(evenly_spaced(path, spacing)))
        for turn in range(rounds):
            if closed:
                middle = 0.5 * (np.roll(points, 1, axis=0) + np.roll(points, -1, axis=0))
                points = points + 0.5 * (middle - points)
            else:
                points[1:-1] += 0.5 * (0.5 * (points[:-2] + points[2:]) - points[1:-1])
            points = self.at(self.nearest(points))
            if turn % 5 == 4 or turn == rounds - 1:
                path = np.concatenate([points, points[:1]]) if closed else points
                points = evenly_spaced(path, spacing)
                points = self.at(self.nearest(points[:-1] if closed and turn % 5 == 4 else points))
        if closed and np.linalg.norm(points[0] - points[-1]) < 0.3 * spacing:
            points = points[:-1]
        return self.nearest(points)


def evenly_spaced(path: Array, spacing: float) -> Array:
    """The (N, 3) polyline sampled at even steps of about `spacing` (m), ends included."""
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(step)])
    count = max(2, round(along[-1] / spacing) + 1)
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, path[:, i]) for i in range(3)], axis=1)


def hollowness(path: Array, spacing: float, reach: int) -> tuple[Array, Array]:
    """(even points (N, 3) m of a front profile sorted downwards, (N,) 1/m how hollow it is there; bulges negative)."""
    even = evenly_spaced(path, spacing)
    result = np.zeros(len(even))
    for i in range(reach, len(even) - reach):
        before, after = even[i] - even[i - reach], even[i + reach] - even[i]
        cross = before[1] * after[2] - before[2] * after[1]
        size = float(np.linalg.norm(before) * np.linalg.norm(after))
        result[i] = -float(np.arcsin(np.clip(cross / size, -1.0, 1.0))) / (reach * spacing)
    return even, result
