"""Joints (E_J, equation 6) as residuals: the relative motion of the two bones that each links, in expected sizes.

They ask for no gap and no turn beyond the joint's rest (rig/joints.py).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.joints import Joints
from breastrig.rig.model import LEAST_GAP
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class JointRest(StructuredTerm[BodyState]):
    joints: Joints
    name: str = "joint_rest"

    @cached_property
    def _per_size(self) -> Array:
        """(6J,) 1/m for the gaps, 1/rad for the turns"""
        rows = [[max(j.translation_sigma, LEAST_GAP)] * 3 + [j.rotation_sigma] * 3 for j in self.joints.joints]
        return 1.0 / np.asarray(rows, dtype=np.float64).ravel()

    def residual(self, state: BodyState) -> Array:
        """(6J,)"""
        motion = state.motion(self.joints)
        return np.concatenate([motion.gap, motion.turn], axis=1).ravel() * self._per_size

    def linearise(self, state: BodyState) -> Linearisation:
        """(6J,), (6J, P)"""
        jacobian = state.motion(self.joints).jacobian.reshape(-1, state.dof)
        return Linearisation(self.residual(state), jacobian * self._per_size[:, None])

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|²"""
        found = self.linearise(state)
        jacobian, residual = found.jacobian, found.residual
        return NormalEquations(jacobian.T @ jacobian, jacobian.T @ residual, 0.5 * float(residual @ residual))
