"""A finer mesh of the same surface."""

import numpy as np
import trimesh


def subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle cut in four; the surface stays exactly the same."""
    fine, triangles = trimesh.remesh.subdivide(vertices, faces)
    return np.asarray(fine, dtype=np.float64), np.asarray(triangles, dtype=np.int64)
