"""The body prior: one Gaussian over all bone scales and shape weights (equations 4 and 5 joined).

r = A (θ − μ) with Aᵀ A = Σ⁻¹ and θ the scales, bone by bone, then the weights. With a diagonal Σ these are the two
priors of the paper; with a covariance estimated on bodies a broad chest is also expected to be deep, and a part that no
scan shows follows those that it does.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import ConstantTerm
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class BodyPrior(ConstantTerm[BodyState]):
    rig: Rig
    mean: Array  # (N,) N = 3 B + S
    covariance: Array  # (N, N)
    name: str = "body_prior"

    @cached_property
    def _whitening(self) -> Array:
        """(N, N)"""
        return solve_lower(cholesky(self.covariance), np.eye(len(self.covariance)))

    def residual(self, state: BodyState) -> Array:
        """(N,)"""
        body = np.concatenate([state.x.scales.ravel(), state.x.weights])
        return np.asarray(self._whitening @ (body - self.mean))

    def slope(self) -> Array:
        """(N, P)"""
        bones, white = len(self.rig.bones), self._whitening
        jacobian = np.zeros((len(white), BONE_DOFS * bones + len(self.rig.shapes)))
        scales = jacobian[:, : BONE_DOFS * bones].reshape(len(white), bones, BONE_DOFS)[:, :, 6:9]
        scales[:] = white[:, : 3 * bones].reshape(len(white), bones, 3)
        jacobian[:, BONE_DOFS * bones :] = white[:, 3 * bones :]
        return jacobian
