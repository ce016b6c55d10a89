"""No joint turns farther than the rig allows: one-sided, so inside the limit it costs nothing.

r_j = max(0, |turn_j| − limit_j) / σ.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.joints import Joints
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class JointLimits:
    joints: Joints
    sigma: float  # rad, how softly the limit is met
    name: str = "joint_limits"

    @cached_property
    def _limits(self) -> Array:
        """(J,) rad"""
        return np.array([joint.rotation_limit for joint in self.joints.joints])

    def _angles(self, state: BodyState) -> tuple[Array, Array, Array]:
        """(J, 3) turn, (J,) its angle, (J,) excess over the limit"""
        turn = state.motion(self.joints).turn
        angle = np.linalg.norm(turn, axis=1)
        return turn, angle, np.maximum(angle - self._limits, 0.0)

    def residual(self, state: BodyState) -> Array:
        """(J,)"""
        return np.asarray(self._angles(state)[2] / self.sigma)

    def linearise(self, state: BodyState) -> Linearisation:
        """(J,), (J, P)"""
        turn, angle, excess = self._angles(state)
        jacobian, beyond = np.zeros((len(excess), state.dof)), np.flatnonzero(excess > 0.0)  # few, in most states none
        if len(beyond):
            direction = turn[beyond] / (self.sigma * np.maximum(angle[beyond], 1e-12)[:, None])
            jacobian[beyond] = np.einsum("ji,jip->jp", direction, state.motion(self.joints).jacobian[beyond, 3:])
        return Linearisation(excess / self.sigma, jacobian)
