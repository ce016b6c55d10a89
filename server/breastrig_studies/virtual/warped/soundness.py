"""Whether a changed skin is still a skin: no triangle turned over, none squeezed to nothing or torn wide."""

import numpy as np
from trimesh.graph import face_adjacency

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_crosses

TURNED = 0.0  # cosine between a triangle before and after, turned with its surroundings
SQUEEZED, TORN = 0.15, 6.0  # of its area
FOLDED = -0.3  # cosine between neighbouring triangles: a fold under a breast has 0.1, a triangle turned over near -1
FEW = 0.001  # share of the triangles that may be unsound under a breast that hangs: narrower than a camera sees


def is_sound(before: Array, after: Array, faces: Integers) -> bool:
    """Of two skins (V, 3) m on the same (F, 3) triangles."""
    old, new = face_crosses(before, faces), face_crosses(after, faces)
    areas, grown = np.linalg.norm(old, axis=1), np.linalg.norm(new, axis=1)
    flat = areas < 1e-9  # m², no triangle to speak of in the source
    cosines = np.einsum("fi,fi->f", old, new) / np.maximum(areas * grown, 1e-18)
    share = grown / np.maximum(areas, 1e-18)
    return bool((flat | ((cosines > TURNED) & (share > SQUEEZED) & (share < TORN))).all())


def is_sound_hanging(before: Array, after: Array, faces: Integers) -> bool:
    """Likewise of a body whose breasts came to hang: skin there turns far, but not against the skin beside it."""
    old, new = face_crosses(before, faces), face_crosses(after, faces)
    areas, grown = (np.maximum(np.linalg.norm(each, axis=1), 1e-12) for each in (old, new))
    share = grown / areas
    a, b = face_adjacency(faces).T
    was, came = (
        np.einsum("ei,ei->e", crosses[a], crosses[b]) / (size[a] * size[b])
        for crosses, size in ((old, areas), (new, grown))
    )
    bad = (areas > 1e-9) & ((share < SQUEEZED) | (share > TORN))
    folded = (came < FOLDED) & (was >= FOLDED)
    bad[a[folded]] = True
    return bool(bad.mean() <= FEW)
