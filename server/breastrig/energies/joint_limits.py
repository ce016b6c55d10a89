"""No joint turns farther than the rig allows: one-sided, so inside the limit it costs nothing.

r_j = max(0, |turn_j| − limit_j) / σ.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.joints import Joints
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True, eq=False)
class JointLimits:
    joints: Joints
    sigma: float  # rad, how softly the limit is met
    name: str = "joint_limits"

    @cached_property
    def _limits(self) -> Array:
        """(J,) rad"""
        return np.array([joint.rotation_limit for joint in self.joints.joints])

    def _angles(self, x: RigParameters) -> tuple[Array, Array, Array]:
        """(J, 3) turn, (J,) its angle, (J,) excess over the limit"""
        turn = self.joints.motion(x).turn
        angle = np.linalg.norm(turn, axis=1)
        return turn, angle, np.maximum(angle - self._limits, 0.0)

    def residual(self, x: RigParameters) -> Array:
        """(J,)"""
        return np.asarray(self._angles(x)[2] / self.sigma)

    def linearise(self, x: RigParameters) -> Linearisation:
        """(J,), (J, P)"""
        turn, angle, excess = self._angles(x)
        direction = np.where((excess > 0.0)[:, None], turn / np.maximum(angle, 1e-12)[:, None], 0.0)
        jacobian = np.einsum("ji,jip->jp", direction, self.joints.jacobian(x)[:, 3:]) / self.sigma
        return Linearisation(excess / self.sigma, jacobian)
