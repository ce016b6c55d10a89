"""Joints as compliant constraints (E_J, equation 6) on the relative motion of the two bones that they link.

The constraint asks for no gap and no turn beyond the joint's rest (rig/joints.py); its compliance is the square of
the expected size, 0 is a hard joint.  It enters the solver with Lagrange multipliers (least_squares/problem.py).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.joints import Joints
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class JointRest:
    joints: Joints
    name: str = "joint_rest"

    @cached_property
    def compliance(self) -> Array:
        """(6J,) m² for the gaps, rad² for the turns"""
        rows = [[j.translation_sigma**2] * 3 + [j.rotation_sigma**2] * 3 for j in self.joints.joints]
        return np.asarray(rows, dtype=np.float64).ravel()

    def residual(self, state: BodyState) -> Array:
        """(6J,)"""
        motion = state.motion(self.joints)
        return np.concatenate([motion.gap, motion.turn], axis=1).ravel()

    def linearise(self, state: BodyState) -> Linearisation:
        """(6J,), (6J, P)"""
        return Linearisation(self.residual(state), state.motion(self.joints).jacobian.reshape(-1, state.dof))
