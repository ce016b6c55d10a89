"""Bone scales near one (E_S, equation 4) and neighbouring bones alike.

r = (s − 1)/σ for each bone and axis, and (s_parent − s_child)/σ_n for each joint whose bones have the same
rest axes (their mean scales otherwise).  The second part is ours: a scan that ends at the navel says nothing
of the pelvis, and its scale should then follow the spine instead of staying at one or swelling.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import ConstantTerm
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class ScalePrior(ConstantTerm[BodyState]):
    rig: Rig
    sigma: float  # expected deviation of a scale from one
    neighbour_sigma: float  # expected difference between neighbours
    name: str = "scale_prior"

    @cached_property
    def _matrix(self) -> Array:
        """(M, B, 3)"""
        rig, eye = self.rig, np.eye(3)
        bones = len(rig.bones)
        rows = [np.eye(3 * bones).reshape(-1, bones, 3) / self.sigma]
        for joint in rig.joints:
            same = np.allclose(rig.rest_rotations[joint.parent], rig.rest_rotations[joint.child], atol=1e-3)
            row = np.zeros((3, bones, 3) if same else (1, bones, 3))
            row[:, joint.parent] = eye if same else 1.0 / 3.0
            row[:, joint.child] = -eye if same else -1.0 / 3.0
            rows.append(row / self.neighbour_sigma)
        return np.concatenate(rows)

    def residual(self, state: BodyState) -> Array:
        """(M,)"""
        return np.asarray(np.einsum("mba,ba->m", self._matrix, state.x.scales - 1.0))

    def slope(self) -> Array:
        """(M, P)"""
        matrix, bones = self._matrix, len(self.rig.bones)
        jacobian = np.zeros((len(matrix), BONE_DOFS * bones + len(self.rig.shapes)))
        jacobian[:, : BONE_DOFS * bones].reshape(len(matrix), -1, BONE_DOFS)[:, :, 6:9] = matrix
        return jacobian
