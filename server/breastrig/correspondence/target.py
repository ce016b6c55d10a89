"""A scan made ready to be asked for matches: built once a fit, then only read.

Holds the scan centred at its mean (float32 rays are precise near the origin), smoothed normals, the open
borders, the ray scene and the k-d trees.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.geometry.rays import HAVE_EMBREE, RayCaster

SMOOTHING_ROUNDS = 2  # rounds of neighbour averaging of the normals: a depth camera's noise tilts single triangles


@dataclass(frozen=True, eq=False)
class ScanTarget:
    """(V, 3) vertices in m and (F, 3) triangles, counter-clockwise from outside."""

    vertices: Array
    faces: Integers
    use_rays: bool = True  # False: trees only, as on platforms without embreex

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit vertex normals, averaged over neighbours."""
        normals = vertex_normals(self.vertices, self.faces)
        i, j = self.faces[:, [0, 1, 2]].ravel(), self.faces[:, [1, 2, 0]].ravel()
        size = len(self.vertices)
        near = sp.csr_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=(size, size))
        for _ in range(SMOOTHING_ROUNDS):
            normals = normals + near @ normals
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return np.asarray(normals)

    @cached_property
    def face_normals(self) -> Array:
        """(F, 3)"""
        return face_normals(self.vertices, self.faces)

    @cached_property
    def on_border(self) -> Booleans:
        """(V,) vertices of open edges"""
        return np.asarray(boundary_vertices(self.faces, len(self.vertices)))

    @cached_property
    def border_share(self) -> Array:
        """(V,) 1.0 on the border, else 0.0: mixed by barycentric weights it says how much of a point is border"""
        return np.asarray(self.on_border, dtype=np.float64)

    @cached_property
    def search(self) -> ClosestPointSearch:
        return ClosestPointSearch(self.vertices, self.faces)

    @cached_property
    def rays(self) -> RayCaster | None:
        return RayCaster(self.vertices, self.faces) if HAVE_EMBREE and self.use_rays else None

    @cached_property
    def vertex_tree(self) -> cKDTree:
        return cKDTree(self.vertices, balanced_tree=False, compact_nodes=False)

    @cached_property
    def faces_of_vertex(self) -> tuple[Integers, Integers]:
        """offsets (V+1,) into a list (3F,) of the triangles around each vertex"""
        order = np.argsort(self.faces.ravel(), kind="stable")
        counts = np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64), order // 3

    def normals_at(self, faces: Integers, barycentric: Array) -> Array:
        """(M, 3) unit normals interpolated inside the triangles."""
        mixed = np.einsum("mc,mcd->md", barycentric, self.normals[self.faces[faces]])
        return np.asarray(mixed / np.maximum(np.sqrt(np.einsum("mi,mi->m", mixed, mixed)), 1e-12)[:, None])
