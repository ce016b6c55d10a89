"""A point on a triangle mesh as (face, barycentric): it follows the mesh wherever the mesh goes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.geometry.normals import face_areas, unit_vectors


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """M points on a mesh."""

    faces: Integers  # (M,) index of the triangle
    barycentric: Array  # (M, 3) weights of its corners, each row sums to 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, np.int64))
        object.__setattr__(self, "barycentric", frozen(self.barycentric))

    def __len__(self) -> int:
        return len(self.faces)

    def __getitem__(self, chosen: Integers | Sequence[int] | slice) -> "SurfacePoints":
        """The points at these indices."""
        return SurfacePoints(self.faces[chosen], self.barycentric[chosen])

    def positions(self, vertices: Array, triangles: Integers) -> Array:
        """(M, 3) m: the points on a mesh with these (V, 3) vertices and (F, 3) triangles."""
        corners = vertices[triangles[self.faces]]
        return np.asarray(np.einsum("mc,mcd->md", self.barycentric, corners))

    def directions(self, normals: Array, triangles: Integers) -> Array:
        """(M, 3) unit: out of a mesh with these (V, 3) normals at its vertices and (F, 3) triangles."""
        return unit_vectors(self.positions(normals, triangles))


def joined(parts: Sequence[SurfacePoints]) -> SurfacePoints:
    """All points concatenated."""
    return SurfacePoints(
        np.concatenate([part.faces for part in parts]), np.concatenate([part.barycentric for part in parts])
    )


class ChordalDeviation:
    """The chordal deviation of a mesh with fixed (F, 3) triangles; areas are those at the (V, 3) m vertices `rest`."""

    def __init__(self, rest: Array, faces: Integers) -> None:
        count, areas = len(rest), face_areas(rest, faces)
        own = np.bincount(faces.ravel(), np.repeat(areas / 3.0, 3), count)
        first, second = faces.ravel(), faces[:, [1, 2, 0]].ravel()
        ends = np.concatenate([first, second]), np.concatenate([second, first])
        shares = np.repeat(areas / 6.0, 3) / 8.0
        inverse = 1.0 / np.where(own > 0.0, own, 1.0)
        self._shares = csr_array((np.tile(shares, 2) * inverse[ends[0]], ends), shape=(count, count))
        self._total = np.asarray(self._shares.sum(axis=1))

    def __call__(self, vertices: Array, normals: Array) -> Array:
        """(V,) m, mean of the triangles around each of these (V, 3) m vertices with unit (V, 3) normals.

        The sum over the edges of a vertex is multiplied out: one sparse product instead of a pass over all edges.
        """
        heights = np.einsum("vi,vi->v", normals, vertices)
        near = self._shares @ np.column_stack([heights, normals, vertices])
        across = np.einsum("vi,vi->v", near[:, 1:4], vertices) + np.einsum("vi,vi->v", near[:, 4:7], normals)
        return np.asarray(near[:, 0] - across + self._total * heights)
