"""What bodies have in common, as one Gaussian over all bone scales and shape weights (equations 4 and 5 joined).

r = A (θ − μ) with Aᵀ A = Σ⁻¹ and θ the scales, bone by bone, then the weights.  With a diagonal Σ these are the two
priors of the paper; with what is known of bodies a broad chest is also expected to be deep, and a part that no scan
shows follows those that it does.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.newton import System
from breastrig.least_squares.problem import HARD, ConstantJacobian, Linearisation, NormalEquations, StructuredTerm
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState

CERTAIN = 1e-9  # chance below which one of two is out of the question
FLOOR = 1e-9  # of the Hessian's diagonal: keeps what nothing holds out of the factor


@dataclass(frozen=True, eq=False)
class BodyPrior(StructuredTerm[BodyState]):
    rig: Rig
    mean: Array  # (N,) N = 3 B + S
    covariance: Array  # (N, N)
    name: str = "body_prior"

    @cached_property
    def _whitening(self) -> Array:
        """(N, N)"""
        return solve_lower(cholesky(self.covariance), np.eye(len(self.covariance)))

    @cached_property
    def precision(self) -> Array:
        """(N, N)"""
        return np.asarray(self._whitening.T @ self._whitening)

    def evidence(self, state: BodyState, others: System) -> float:
        """Logarithm of the integral of this density times exp(-others) over all steps from here, up to a constant."""
        own, held = self.normal_equations(state), others.constraint_jacobian
        stiff = 1.0 / np.maximum(others.compliance, HARD)
        hessian = others.hessian + own.hessian + held.T @ (held * stiff[:, None])
        factor = cholesky(hessian + FLOOR * np.diag(np.diag(hessian)))
        fall = solve_lower(factor, others.gradient + own.gradient + held.T @ (stiff * others.constraint))
        volume = np.log(np.diag(self._whitening)).sum() - np.log(np.diag(factor)).sum()
        return float(volume + 0.5 * fall @ fall - own.energy)

    def residual(self, state: BodyState) -> Array:
        """(N,)"""
        body = np.concatenate([state.x.scales.ravel(), state.x.weights])
        return np.asarray(self._whitening @ (body - self.mean))

    @cached_property
    def _slope(self) -> ConstantJacobian:
        """(N, P)"""
        bones, white = len(self.rig.bones), self._whitening
        jacobian = np.zeros((len(white), BONE_DOFS * bones + len(self.rig.shapes)))
        scales = jacobian[:, : BONE_DOFS * bones].reshape(len(white), bones, BONE_DOFS)[:, :, 6:9]
        scales[:] = white[:, : 3 * bones].reshape(len(white), bones, 3)
        jacobian[:, BONE_DOFS * bones :] = white[:, 3 * bones :]
        return ConstantJacobian(jacobian)

    def linearise(self, state: BodyState) -> Linearisation:
        """(N,), (N, P)"""
        return Linearisation(self.residual(state), self._slope.jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """With JᵀJ formed once."""
        return self._slope.normal_equations(self.residual(state))


@dataclass(frozen=True, eq=False)
class EitherBody:
    """Two bodies of equal odds, for instance a clinic's women and all: the scan decides which of them this woman is.

    Each is weighted by its evidence, what else is known being integrated out with it (Laplace's approximation): by the
    density where the fit stands the narrower one would always win.
    """

    first: BodyPrior
    second: BodyPrior

    def weighted(self, state: BodyState, others: System) -> BodyPrior:
        """What counts at this state, where all else is `others`: one alone where the other is out of the question."""
        rises = [each.evidence(state, others) for each in (self.second, self.first)]
        chance = float(1.0 / (1.0 + np.exp(np.clip(rises[0] - rises[1], -500.0, 500.0))))  # of the first
        if not CERTAIN < chance < 1.0 - CERTAIN:
            return self.first if chance > 0.5 else self.second
        informed = [
            (share * each.precision, share * each.precision @ each.mean)
            for share, each in ((chance, self.first), (1.0 - chance, self.second))
        ]
        precision, pull = informed[0][0] + informed[1][0], informed[0][1] + informed[1][1]
        covariance = np.linalg.inv(precision)
        return BodyPrior(self.first.rig, covariance @ pull, 0.5 * (covariance + covariance.T))
