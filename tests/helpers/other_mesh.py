"""The same surface under another triangulation, none of whose edges is one of the first mesh."""

import numpy as np
import trimesh


def retriangulated(vertices: np.ndarray, faces: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """One vertex for each cube of `spacing` (m) that the (V, 3) m surface passes: that of its points in the middle."""
    fine, triangles = trimesh.remesh.subdivide_to_size(vertices, faces, 0.5 * spacing)
    cells = np.floor(fine / spacing + 0.37).astype(np.int64)
    _, inverse = np.unique(cells, axis=0, return_inverse=True)
    inverse = inverse.ravel()
    size = np.bincount(inverse)
    middles = np.stack([np.bincount(inverse, weights=fine[:, k]) / size for k in range(3)], axis=1)
    order = np.lexsort((np.linalg.norm(fine - middles[inverse], axis=1), inverse))
    nearest = order[np.concatenate([[0], np.cumsum(size)[:-1]])]
    corners = inverse[triangles]
    solid = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    _, once = np.unique(np.sort(corners[solid], axis=1), axis=0, return_index=True)
    return fine[nearest], corners[solid][once]
