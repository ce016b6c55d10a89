"""Normals of a triangle mesh, seen from outside when the corners run counter-clockwise.

Vertex normals are area-weighted: the plain sum of the cross products of the triangles around a vertex, which
is what three.js and Blender compute too, so that shading looks the same everywhere.  `VertexNormals` keeps the
incidence of triangles and vertices for meshes whose points move while their triangles stay, as in the fit's
inner loop; the sum is then one sparse product (0.45 ms for 2,200 vertices).
"""

import numpy as np
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Integers


def face_crosses(vertices: Array, faces: Integers) -> Array:
    """(F, 3) m²: the normal of each triangle with twice its area as length."""
    return _crosses(vertices, np.ascontiguousarray(faces.T))


def _crosses(vertices: Array, corners: Integers) -> Array:
    """The same for (3, F) corners; axis by axis, which is several times faster than numpy.cross at this size."""
    axes = np.ascontiguousarray(vertices.T)
    first, second, third = (axes.take(corner, axis=1) for corner in corners)
    (x, y, z), (u, v, w) = second - first, third - first
    result = np.zeros((corners.shape[1], 3))
    np.subtract(y * w, z * v, out=result[:, 0])
    np.subtract(z * u, x * w, out=result[:, 1])
    np.subtract(x * v, y * u, out=result[:, 2])
    return result


def face_areas(vertices: Array, faces: Integers) -> Array:
    """(F,) m²."""
    return np.asarray(0.5 * np.linalg.norm(face_crosses(vertices, faces), axis=1))


def face_normals(vertices: Array, faces: Integers) -> Array:
    """(F, 3) unit vectors; +Z for a triangle without area."""
    return _unit(face_crosses(vertices, faces))


def vertex_normals(vertices: Array, faces: Integers) -> Array:
    """(V, 3) unit vectors; +Z where a vertex has no triangle or only flat ones."""
    return VertexNormals(faces, len(vertices))(vertices)


class VertexNormals:
    """Vertex normals of a mesh with fixed (F, 3) triangles and moving vertices."""

    def __init__(self, faces: Integers, vertex_count: int) -> None:
        self._corners = np.ascontiguousarray(faces.T)
        owners = np.repeat(np.arange(len(faces)), 3)
        self._incidence = csr_array((np.ones(faces.size), (faces.ravel(), owners)), shape=(vertex_count, len(faces)))

    def __call__(self, vertices: Array) -> Array:
        """(V, 3) unit vectors for these (V, 3) vertices; +Z where a vertex has no triangle or only flat ones."""
        return _unit(np.asarray(self._incidence @ _crosses(vertices, self._corners)))

    def summed(self, values: Array) -> Array:
        """(V, D): of (F, D) values, those of the triangles around each vertex."""
        return np.asarray(self._incidence @ values)


def _unit(vectors: Array) -> Array:
    lengths = np.sqrt(np.einsum("mi,mi->m", vectors, vectors))
    if (lengths > 0).all():
        return np.asarray(vectors / lengths[:, None])
    found = (lengths > 0)[:, None]
    return np.where(found, vectors / np.where(found, lengths[:, None], 1.0), [0.0, 0.0, 1.0])
