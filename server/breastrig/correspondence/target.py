"""A scan made ready to be asked for matches: built once a fit, then only read.

Everything goes in and comes out in the scan's own frame, wherever its origin is; what works in float32 keeps an origin
of its own (geometry/rays.py).  Holds smoothed normals, the open borders, the ray scene, the tree of triangles and the
k-d tree of vertices.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers, any_in_row, lengths, stable_order
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import VertexNormals, face_normals
from breastrig.geometry.plane import Plane
from breastrig.geometry.rays import HAVE_EMBREE, RayCaster

SMOOTHING_ROUNDS = 2  # rounds of neighbour averaging of the normals: a depth camera's noise tilts single triangles
BEYOND = (
    0.2  # sine of the angle to the border's own plane; of 240 searches on given scans 215 are spared, 0.4 pairs lost
)


@dataclass(frozen=True, eq=False)
class ScanTarget:
    """(V, 3) vertices in m and (F, 3) triangles, counter-clockwise from outside."""

    vertices: Array
    faces: Integers
    use_rays: bool = True  # False: the tree only, as on platforms without embreex
    table: Plane | None = None  # under a lying patient, its normal to the body; its triangles are not among the faces

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit vertex normals, averaged over neighbours."""
        around = VertexNormals(self.faces, len(self.vertices))
        normals, triangles = around(self.vertices), np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        own = 1.0 - triangles[:, None]  # each triangle around a vertex adds its two neighbours, and here itself too
        for _ in range(SMOOTHING_ROUNDS):
            normals = own * normals + around.summed(sum(normals.take(corner, axis=0) for corner in self.faces.T))
            normals /= np.maximum(np.sqrt(np.einsum("vi,vi->v", normals, normals)), 1e-12)[:, None]
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
    def mixed_values(self) -> Array:
        """(V, 7): position (m), normal, and 1 on the border, side by side, so that matching gathers once."""
        return np.column_stack([self.vertices, self.normals, self.on_border])

    @cached_property
    def search(self) -> ClosestPointSearch:
        return ClosestPointSearch(self.vertices, self.faces)

    @cached_property
    def _gap(self) -> float:
        """m, how far a point of a triangle can be from all of its corners: as in an equilateral one of this size."""
        corners = [self.vertices.take(corner, axis=0) for corner in self.faces.T]
        ends = (corners[k] - corners[k - 1] for k in range(3))
        return float(np.sqrt(max(np.einsum("fi,fi->f", end, end).max(initial=0.0) for end in ends) / 3.0))

    @cached_property
    def border_directions(self) -> Array:
        """(V, 3) unit vectors out of the scan at the vertices of its border, 0 elsewhere."""
        corners = self.faces[any_in_row(self.on_border[self.faces])]
        away = self.vertices[corners] - self.vertices[corners].mean(axis=1, keepdims=True)
        size, of = len(self.vertices), corners.ravel()
        sums: Array = np.stack([np.bincount(of, away[:, :, axis].ravel(), size) for axis in range(3)], axis=1)
        sums[~self.on_border] = 0.0
        return np.asarray(sums / np.maximum(lengths(sums)[:, None], 1e-12))

    def may_be_matched(self, points: Array, reach: float, reject_border: bool) -> Integers:
        """Indices of the (M, 3) m points that are not certainly farther than `reach` (m) from the scan.

        With `reject_border` those that lie beyond it, seen from their nearest vertex, are left out too.  To rule out
        takes a fifth of the time of a search for the closest point.
        """
        distances, nearest = self.vertex_tree.query(points, distance_upper_bound=reach + self._gap)
        near = np.flatnonzero(np.isfinite(distances))
        if not reject_border:
            return near
        at, away = np.asarray(nearest).take(near), np.asarray(distances).take(near)
        gaps = points.take(near, axis=0) - self.vertices.take(at, axis=0)
        outwards = np.einsum("mi,mi->m", gaps, self.border_directions.take(at, axis=0))
        return np.asarray(near[outwards <= BEYOND * away])

    @cached_property
    def rays(self) -> RayCaster | None:
        return RayCaster(self.vertices, self.faces) if HAVE_EMBREE and self.use_rays else None

    @cached_property
    def vertex_tree(self) -> cKDTree:
        return cKDTree(self.vertices, balanced_tree=False, compact_nodes=False)

    @cached_property
    def faces_of_vertex(self) -> tuple[Integers, Integers]:
        """offsets (V+1,) into a list (3F,) of the triangles around each vertex"""
        order = stable_order(self.faces.ravel())
        counts = np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64), order // 3

    def surface_at(self, faces: Integers, barycentric: Array) -> tuple[Array, Array, Array]:
        """(M, 3) m points, (M, 3) unit normals and (M,) share of border vertices at M places inside triangles."""
        corners, mixed = self.faces.take(faces, axis=0), np.zeros((len(faces), 7))
        for corner in range(3):
            mixed += self.mixed_values.take(corners[:, corner], axis=0) * barycentric[:, corner, None]
        normals = mixed[:, 3:6]
        lengths = np.sqrt(np.einsum("mi,mi->m", normals, normals))
        return mixed[:, :3], normals / np.maximum(lengths, 1e-12)[:, None], mixed[:, 6]
