"""First hits of rays on a triangle mesh, by Embree through the embreex package.

What embreex 4.4 does that a caller would not expect, and what is done about it here:

* it works in float32: the mesh is centred at its mean, so that hits are right to about 0.1 µm on a body;
* without `robust` three rays in a hundred slip through at shared vertices: always on;
* distances are written in place into a float32 array which is also the limit, and a miss keeps the limit:
  a fresh array for each call, and misses are marked by the face index;
* wrong indices or short arrays are read beyond their end: both are checked first;
* a ray that starts on the surface hits it at distance 0 about half of the time: shift the origin if it matters;
* triangles are copied in a slow loop and the tree is built by the first query (70 ms for 80,000 triangles):
  build once a mesh; the first query is made on construction.

embreex has no wheel on some platforms (Linux on ARM, musl); `HAVE_EMBREE` says whether rays are there at all.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BreastRigError
from breastrig.geometry.closest_point import check_mesh

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    HAVE_EMBREE = True
except ImportError:  # pragma: no cover - depends on the platform
    HAVE_EMBREE = False


class NoRays(BreastRigError):
    """embreex is not installed."""


@dataclass(frozen=True, eq=False)
class RayHits:
    """The hits of M rays on a mesh."""

    faces: Integers  # (M,) -1: nothing
    distances: Array  # (M,) m, inf: nothing
    second: Array  # (M,) barycentric weight of the triangle's second corner; 0 where nothing
    third: Array  # (M,) of its third


class RayCaster:
    """Rays against one fixed mesh of (V, 3) vertices (m) and (F, 3) triangles.

    Raises NoRays where embreex is missing, ValueError when a triangle names a vertex that is not there or a
    vertex is not finite.
    """

    def __init__(self, vertices: Array, faces: Integers) -> None:
        if not HAVE_EMBREE:
            raise NoRays("Rays need the package embreex, which is not installed here; install embreex.")
        vertices, faces = np.asarray(vertices, dtype=np.float64), np.asarray(faces)
        check_mesh(vertices, faces)
        self._centre = vertices.mean(axis=0) if len(vertices) else np.zeros(3)
        self._scene = None
        if len(faces):
            self._scene = EmbreeScene(robust=True)
            TriangleMesh(self._scene, (vertices - self._centre).astype(np.float32), faces.astype(np.int32))
            self.first_hits(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))  # Embree builds its tree at the first call

    def first_hits(
        self, origins: Array, directions: Array, max_distance: float | Array = np.inf
    ) -> tuple[Integers, Array]:
        """((M,) triangle or -1, (M,) distance in m or inf): the first half of `hits`."""
        found = self.hits(origins, directions, max_distance)
        return found.faces, found.distances

    def hits(self, origins: Array, directions: Array, max_distance: float | Array = np.inf) -> RayHits:
        """First hits of M rays from (M, 3) origins (m) along (M, 3) unit directions.

        Both sides of a triangle are hit.  `max_distance` is one number or one for each ray.  A ray that is not
        finite misses.
        """
        if origins.shape != directions.shape or origins.ndim != 2 or origins.shape[1] != 3:
            raise ValueError("Origins and directions must both be of shape (M, 3).")
        count = len(origins)
        if self._scene is None or count == 0:
            return RayHits(np.full(count, -1, dtype=np.int64), np.full(count, np.inf), *np.zeros((2, count)))
        limit = np.zeros(count, dtype=np.float32)
        limit[:] = np.minimum(max_distance, 1e30)
        start = np.asarray(origins - self._centre, dtype=np.float32, order="C")
        along = np.asarray(directions, dtype=np.float32, order="C")
        if not (np.isfinite(start).all() and np.isfinite(along).all()):
            sound = np.asarray(np.isfinite(start).all(axis=1) & np.isfinite(along).all(axis=1))
            start, along = np.where(sound[:, None], start, np.float32(0.0)), along.copy()
            along[~sound], limit[~sound] = (0.0, 0.0, 1.0), -1.0
        hits = self._scene.run(start, along, dists=limit, output=True)
        faces = hits["primID"].astype(np.int64)
        missed = faces < 0
        distances, second, third = (hits[key].astype(np.float64) for key in ("tfar", "u", "v"))
        distances[missed], second[missed], third[missed] = np.inf, 0.0, 0.0
        return RayHits(faces, distances, second, third)
