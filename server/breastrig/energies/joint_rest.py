"""Joints as compliant constraints (E_J, equation 6) on the relative motion of the two bones that they link.

With G_j = R_j Q_jᵀ the rotation of bone j from rest and X_j(a) the place to which bone j (rotated, scaled,
moved) carries the joint's anchor a:

    g_t = G_pᵀ (X_c(a) − X_p(a))                       the joint's gap, in the parent's axes (m)
    g_r = log(G*ᵀ G_pᵀ G_c)                            the relative rotation beyond its rest G* (rad)

The compliance is the square of the expected size; 0 is a hard joint.  Both sides of the anchor move with the
bones' scales, as the paper's section 2.2 asks ("a rigid point attached to the scalable bones").
"""

from dataclasses import dataclass, field

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.rotations import exp_so3, hat, log_so3, right_jacobian_inverse
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Joint, Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


@dataclass(frozen=True, eq=False)
class JointRest:
    rig: Rig
    joints: tuple[Joint, ...]  # the rig's own, or with other sigmas
    rest: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (J, 3) rad, relative rest rotation G*; empty: none
    name: str = "joint_rest"

    @property
    def compliance(self) -> Array:
        """(6J,) m² for the gaps, rad² for the rotations"""
        rows = [[j.translation_sigma**2] * 3 + [j.rotation_sigma**2] * 3 for j in self.joints]
        return np.asarray(rows, dtype=np.float64).ravel()

    def _gap(self, joint: Joint, x: RigParameters) -> tuple[Array, Array, Array]:
        """gap in world axes, and the anchor in each bone's own axes before scaling"""
        rig = self.rig
        u_p = rig.rest_rotations[joint.parent].T @ (joint.anchor - rig.rest_origins[joint.parent])
        u_c = rig.rest_rotations[joint.child].T @ (joint.anchor - rig.rest_origins[joint.child])
        at_p = x.rotations[joint.parent] @ (x.scales[joint.parent] * u_p) + x.translations[joint.parent]
        at_c = x.rotations[joint.child] @ (x.scales[joint.child] * u_c) + x.translations[joint.child]
        return at_c - at_p, u_p, u_c

    def residual(self, x: RigParameters) -> Array:
        """(6J,)"""
        return self.linearise(x).residual

    def linearise(self, x: RigParameters) -> Linearisation:
        """(6J,), (6J, P)"""
        rig = self.rig
        rest = exp_so3(self.rest) if len(self.rest) else np.tile(np.eye(3), (len(self.joints), 1, 1))
        residual = np.zeros((len(self.joints), 6))
        jacobian = np.zeros((len(self.joints), 6, x.dof))
        for row, joint in enumerate(self.joints):
            p, c = joint.parent, joint.child
            q_p, q_c = rig.rest_rotations[p], rig.rest_rotations[c]
            r_p, r_c = x.rotations[p], x.rotations[c]
            into_parent = q_p @ r_p.T  # G_pᵀ
            gap, u_p, u_c = self._gap(joint, x)
            turn = log_so3(rest[row].T @ into_parent @ r_c @ q_c.T)
            residual[row, :3], residual[row, 3:] = into_parent @ gap, turn
            parent, child = (jacobian[row, :, BONE_DOFS * j : BONE_DOFS * (j + 1)] for j in (p, c))
            parent[:3, 0:3] = q_p @ hat(r_p.T @ gap) + into_parent @ r_p @ hat(x.scales[p] * u_p)
            parent[:3, 3:6] = -into_parent
            parent[:3, 6:9] = -into_parent @ r_p * u_p
            child[:3, 0:3] = -into_parent @ r_c @ hat(x.scales[c] * u_c)
            child[:3, 3:6] = into_parent
            child[:3, 6:9] = into_parent @ r_c * u_c
            inverse = right_jacobian_inverse(turn)
            child[3:, 0:3] = inverse @ q_c
            parent[3:, 0:3] = -inverse @ q_c @ r_c.T @ r_p
        return Linearisation(residual.ravel(), jacobian.reshape(-1, x.dof))
