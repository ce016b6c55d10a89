"""The skin that a breast moves, on the rig's template: what lies around it, and the sheet that fills its footprint.

The sheet is the thin-plate spline of the skin around the breast over the unrolled trunk: the skin without the breast.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.rig.model import Rig

AROUND = 0.045  # m of skin around the breast that may move
NEAR = 0.08  # m around the breast from which the sheet is made
SMOOTH = 1e-5  # of the sheet
TRUNK = (0.0, -0.03)  # m: x and z of the axis around which skin is unrolled ...
RADIUS = 0.14  # m: ... and the trunk's radius
OF_AN_ARM = 0.25  # skin weight from which on a vertex is the arm's
MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class BreastSkin:
    """The skin of one side; rows of both sides are each other's mirror images."""

    side: str
    skin: Integers  # (P,) vertices of the rig that the breast moves
    breast: Booleans  # (P,) which of them are the breast
    near: Integers  # (R,) vertices around the breast
    sheet: Array  # (P, R) from the skin around the breast to the sheet under `skin`

    def heights(self, vertices: Array) -> Array:
        """(P, 3) m of (V, 3) m vertices over their sheet."""
        return np.asarray(vertices[self.skin] - self.sheet @ vertices[self.near])


@lru_cache(maxsize=4)
def breast_skins(rig: Rig) -> tuple[BreastSkin, BreastSkin]:
    """The skin of the left and of the right breast; the rig needs its region breast_L, the right one mirrors it."""
    template, breast = rig.template, rig.regions["breast_L"]
    plane = np.stack(
        [RADIUS * np.arctan2(template[:, 0] - TRUNK[0], template[:, 2] - TRUNK[1]), template[:, 1]], axis=1
    )
    away = cKDTree(template[breast]).query(template)[0]
    front = (rig.skin_weights[:, rig.bone_names.index("upper_arm_L")] < OF_AN_ARM) & (template[:, 2] > TRUNK[1])
    skin = np.flatnonzero(front & (away < AROUND) & (template[:, 0] > -1e-6))
    around = front & (away < NEAR) & (template[:, 0] > -AROUND)
    around[np.concatenate([breast, rig.mirror_vertices[breast]])] = False
    near = np.flatnonzero(around)
    from scipy.interpolate import RBFInterpolator  # slow to load, and most fits need no spline

    spline = RBFInterpolator(plane[near], np.eye(len(near)), kernel="thin_plate_spline", smoothing=SMOOTH)
    left = BreastSkin("L", skin, np.isin(skin, breast), near, np.asarray(spline(plane[skin])))
    other = rig.mirror_vertices
    return left, BreastSkin("R", other[skin], left.breast, other[near], left.sheet)
