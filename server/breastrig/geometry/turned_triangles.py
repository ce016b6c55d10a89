"""Triangles of a smooth surface that lie upside down: where it is folded over itself."""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.neighbours import neighbours
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.geometry.unit_vectors import unit_vectors

ROUNDS = 6  # of averaging the normals: a fold is narrower than so many rings of triangles, a breast's fold is wider


def turned_triangles(vertices: Array, faces: Integers) -> Booleans:
    """(F,) those of (V, 3) vertices and (F, 3) triangles that face away from how the surface around them faces."""
    around, mean = neighbours(faces, len(vertices)), vertex_normals(vertices, faces)
    for _ in range(ROUNDS):
        mean = unit_vectors(mean + around @ mean)
    return np.asarray(np.einsum("fi,fi->f", face_normals(vertices, faces), mean[faces].sum(axis=1)) < 0.0)
