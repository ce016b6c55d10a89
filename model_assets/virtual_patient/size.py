"""A woman's size as a tape and a water bath would measure it on her true skin."""

import numpy as np
from scipy.spatial import ConvexHull

from breastrig.geometry.normals import face_crosses

Array = np.ndarray

FRENCH_BAND = 15  # cm that French bands are larger than the girth under the breasts
CUPS = {"A": 13.0, "B": 15.0, "C": 17.0}  # cm that the bust is larger, the middles of EN 13402-3's classes


def girth(vertices: Array, faces: Array, trunk: Array, height: float, side: str) -> float:
    """m: a tape around the (V,) bool trunk at that height, bridging hollows.

    Twice the half of one side ("L" or "R"), so that each breast of an asymmetric woman has its own size.
    """
    above = vertices[:, 1] > height
    edges = faces[trunk[faces].all(axis=1)][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    a, b = edges[above[edges[:, 0]] != above[edges[:, 1]]].T
    share = ((height - vertices[a, 1]) / (vertices[b, 1] - vertices[a, 1]))[:, None]
    cut = ((1.0 - share) * vertices[a] + share * vertices[b])[:, [0, 2]]
    half = cut[cut[:, 0] * (1.0 if side == "L" else -1.0) > 0.0]
    return float(ConvexHull(np.concatenate([half, half * [-1.0, 1.0]])).area)  # SciPy's name for a plane hull's length


def under_bust_and_bust(
    vertices: Array, faces: Array, trunk: Array, nipple: Array, fold: Array, side: str
) -> tuple[float, float]:
    """m: just below the (3,) m fold, and the largest near the height of the (3,) m nipple."""
    heights = nipple[1] + np.array([-0.01, 0.0, 0.01])
    return (
        girth(vertices, faces, trunk, fold[1] - 0.005, side),
        max(girth(vertices, faces, trunk, height, side) for height in heights),
    )


def volume_over(vertices: Array, wall: Array, faces: Array, side: Array) -> float:
    """m³ between the skin and the chest wall on the (V,) bool side."""
    kept = faces[side[faces].all(axis=1)]
    inside = [
        np.einsum("fi,fi->", place[kept].mean(axis=1), face_crosses(place, kept)) / 6.0 for place in (vertices, wall)
    ]
    return float(inside[0] - inside[1])
