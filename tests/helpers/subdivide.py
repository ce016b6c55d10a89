"""A finer mesh of the same surface."""

import numpy as np
import trimesh

from breastrig.geometry.normals import vertex_normals


def subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle cut in four; the surface stays exactly the same."""
    fine, triangles = trimesh.remesh.subdivide(vertices, faces)
    return np.asarray(fine, dtype=np.float64), np.asarray(triangles, dtype=np.int64)


def smoothly_subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle cut in four, the new vertices raised to the curved surface that has the normals of the old ones."""
    count = len(vertices)
    mixed, triangles = trimesh.remesh.subdivide(np.hstack([vertices, np.eye(count)]), faces)
    shares = np.asarray(mixed)[count:, 3:]  # half of each end of an edge
    first, second = np.nonzero(shares)[1].reshape(-1, 2).T
    normals = vertex_normals(vertices, faces)
    sagitta = np.einsum("ei,ei->e", normals[second] - normals[first], vertices[second] - vertices[first]) / 8.0
    middle = normals[first] + normals[second]
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    raised = 0.5 * (vertices[first] + vertices[second]) + sagitta[:, None] * middle
    return np.concatenate([vertices, raised]), np.asarray(triangles, dtype=np.int64)
