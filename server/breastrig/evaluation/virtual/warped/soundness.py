"""Whether a changed skin is still a skin: no triangle turned over, none squeezed to nothing or torn wide."""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_crosses

TURNED = 0.0  # cosine between a triangle before and after, turned with its surroundings
SQUEEZED, TORN = 0.15, 6.0  # of its area


def is_sound(before: Array, after: Array, faces: Integers) -> bool:
    """Of two skins (V, 3) m on the same (F, 3) triangles."""
    old, new = face_crosses(before, faces), face_crosses(after, faces)
    areas, grown = np.linalg.norm(old, axis=1), np.linalg.norm(new, axis=1)
    flat = areas < 1e-9  # m², no triangle to speak of in the source
    cosines = np.einsum("fi,fi->f", old, new) / np.maximum(areas * grown, 1e-18)
    share = grown / np.maximum(areas, 1e-18)
    return bool((flat | ((cosines > TURNED) & (share > SQUEEZED) & (share < TORN))).all())
