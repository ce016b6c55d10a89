"""The toy torso as it would be uploaded: divided finely enough to be read as a scan."""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_normals
from helpers.scan_files import ply_text
from helpers.toy_rig import toy_rig


def torso(unit_per_metre: float = 1.0) -> bytes:
    """An ASCII PLY, upright, half a metre tall, of the skin that a camera in front sees."""
    vertices, faces = toy_rig().template, toy_rig().faces
    for _ in range(2):
        vertices, faces = subdivided(vertices, faces)
    seen = faces[face_normals(vertices, faces)[:, 2] > 0.0]
    used, numbered = np.unique(seen, return_inverse=True)
    return ply_text(np.round(vertices[used] * unit_per_metre, 6), numbered.reshape(-1, 3))


def subdivided(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Each triangle in four."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = (len(vertices) + inverse).reshape(-1, 3).T
    finer = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate([vertices, vertices[unique].mean(axis=1)]), finer
