"""How far the flat triangles of a mesh lie below the curved surface that its vertices are samples of.

The gap over an edge is the sagitta s = (n_j − n_i)·(v_j − v_i) / 8, positive where the surface is convex.  With
barycentric coordinates λ a smooth surface is 4 Σ s_ij λ_i λ_j above a small triangle, which is a third of the sum of
its three sagittas in the mean.  Each triangle's mean is given to the two ends of its edges in equal parts, so that

    Σ_i a_i d_i = ∫ gap,    d_i = Σ_j (A_ij / 6) s_ij / a_i

with A_ij the area of the triangles at an edge and a_i a third of that around a vertex.  Whoever sums something over
vertices instead of integrating it over the triangles (fitting/observation_weights.py) is off by this.
"""

import numpy as np
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_areas


class ChordalDeviation:
    """Of a mesh with fixed (F, 3) triangles and moving vertices; areas are those at the (V, 3) m vertices `rest`."""

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
