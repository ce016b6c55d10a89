"""From standing to prone: breasts that hang to the front, as in a breast MRI; hand-set, nothing was measured.

A place of height h over the chest wall moves to the front by a share of h, and up by a part of it, since it hangs down
no longer. Each breast then narrows towards its own axis until the volume before the wall is what it was.
"""

import numpy as np
from virtual_patient.lying import chest_wall, smoothed

from breastrig.geometry.normals import face_crosses

Array = np.ndarray

FOOTPRINT = 0.06  # share of the breast field from which on skin belongs to the breast
FORWARDS = 0.55  # of the height over the wall
UPWARDS = 0.15
CREASE = 0.012  # m over which creases of the motion are evened out
HALVINGS = 20  # of the interval of how much narrower


def hanging(vertices: Array, faces: Array, breasts: Array) -> tuple[Array, Array]:
    """((V, 3) m of the prone skin, (V, 3) m of the chest wall behind each place); `breasts`: (V,) the breast field."""
    wall = chest_wall(vertices, faces, breasts > FOOTPRINT)
    height = np.maximum((vertices - wall)[:, 2], 0.0)
    motion = height[:, None] * np.array([0.0, UPWARDS, FORWARDS])
    aside = np.zeros_like(vertices)
    for side in (vertices[:, 0] > 0, vertices[:, 0] <= 0):
        middle = (height[side, None] * vertices[side]).sum(axis=0) / height[side].sum()
        share = height[side] / height[side].max()
        aside[side, :2] = -share[:, None] * (vertices[side] - middle)[:, :2]
    volume, narrower, wider = _volume(vertices, faces), 1.0, 0.0
    for _ in range(HALVINGS):
        middle_share = 0.5 * (narrower + wider)
        skin = vertices + smoothed(vertices, faces, motion + middle_share * aside, CREASE)
        narrower, wider = (middle_share, wider) if _volume(skin, faces) < volume else (narrower, middle_share)
    return skin, wall


def _volume(vertices: Array, faces: Array) -> float:
    """m³ of the closed surface."""
    return float(np.einsum("fi,fi->", vertices[faces].mean(axis=1), face_crosses(vertices, faces))) / 6.0
