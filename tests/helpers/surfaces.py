"""Hand-made surfaces whose geometry is known exactly."""

import numpy as np
import trimesh


def sphere(radius: float = 0.1, subdivisions: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (m) and triangles of an icosphere around the origin."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)


def plane(size: float = 0.2, cells: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """A square in z = 0 that faces +Z."""
    side = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(side, side, indexing="xy")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    lower = np.stack([first, first + 1, first + cells + 2], axis=1)
    upper = np.stack([first, first + cells + 2, first + cells + 1], axis=1)
    return vertices, np.concatenate([lower, upper]).astype(np.int64)
