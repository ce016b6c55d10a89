"""A point on a triangle mesh as (face, barycentric): it follows the mesh wherever the mesh goes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.geometry.unit_vectors import unit_vectors


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

    def positions(self, vertices: Array, triangles: Integers) -> Array:
        """(M, 3) m: the points on a mesh with these (V, 3) vertices and (F, 3) triangles."""
        corners = vertices[triangles[self.faces]]
        return np.asarray(np.einsum("mc,mcd->md", self.barycentric, corners))

    def directions(self, normals: Array, triangles: Integers) -> Array:
        """(M, 3) unit: out of a mesh with these (V, 3) normals at its vertices and (F, 3) triangles."""
        return unit_vectors(self.positions(normals, triangles))


def joined(parts: Sequence[SurfacePoints]) -> SurfacePoints:
    """All of them, one after the other."""
    return SurfacePoints(
        np.concatenate([part.faces for part in parts]), np.concatenate([part.barycentric for part in parts])
    )
