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
FLOOR = 1e-9  # of the Hessian's diagonal


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
        factor = cholesky(_with_constraints(others) + own.hessian)
        pull = held.T @ (others.constraint / np.maximum(others.compliance, HARD))
        fall = solve_lower(factor, others.gradient + own.gradient + pull)
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

    @property
    def slope(self) -> Array:
        """(N, P)"""
        return self._slope.jacobian

    def linearise(self, state: BodyState) -> Linearisation:
        """(N,), (N, P)"""
        return Linearisation(self.residual(state), self.slope)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """With JᵀJ formed once."""
        return self._slope.normal_equations(self.residual(state))


@dataclass(frozen=True, eq=False)
class EitherBody:
    """A cohort's body or the built-in one: the scan decides which of them this woman is.

    By evidence, what else is known being integrated out (Laplace's approximation): by the density where the fit stands
    the narrower one would always win.  She is one of the cohort where her scan speaks for it as much as one of them is
    expected to; all women speak for it a little, as the built-in body is wide (docs/decisions/0027).
    """

    first: BodyPrior
    second: BodyPrior

    def weighted(self, state: BodyState, others: System) -> BodyPrior:
        """What counts at this state, where all else is `others`: one alone where the other is out of the question."""
        gain = self.first.evidence(state, others) - self.second.evidence(state, others)
        beyond = gain - self.expected_gain(others)
        chance = float(1.0 / (1.0 + np.exp(np.clip(-beyond, -500.0, 500.0))))  # of the first
        if not CERTAIN < chance < 1.0 - CERTAIN:
            return self.first if chance > 0.5 else self.second
        informed = [
            (share * each.precision, share * each.precision @ each.mean)
            for share, each in ((chance, self.first), (1.0 - chance, self.second))
        ]
        precision, pull = informed[0][0] + informed[1][0], informed[0][1] + informed[1][1]
        covariance = np.linalg.inv(precision)
        return BodyPrior(self.first.rig, covariance @ pull, 0.5 * (covariance + covariance.T))

    def expected_gain(self, others: System) -> float:
        """Mean by which the first one's evidence is larger where she is drawn from it: a Kullback-Leibler divergence.

        Of what a scan with the information in `others` says, everything but scales and weights integrated out.
        """
        body = np.flatnonzero(self.first.slope.any(axis=0))
        rest = np.setdiff1d(np.arange(len(others.gradient)), body)
        known = _with_constraints(others)
        across = known[np.ix_(rest, body)]
        information = known[np.ix_(body, body)] - across.T @ np.linalg.solve(known[np.ix_(rest, rest)], across)
        sizes, axes = np.linalg.eigh(0.5 * (information + information.T))
        seen = np.sqrt(np.maximum(sizes, 0.0))[:, None] * axes.T  # in units of its noise
        first, second = (seen @ each.covariance @ seen.T + np.eye(len(body)) for each in (self.first, self.second))
        away = seen @ (self.first.mean - self.second.mean)
        ratio = np.linalg.solve(second, first)
        spread = np.trace(ratio) - len(body) - np.linalg.slogdet(ratio)[1]
        return float(0.5 * (spread + away @ np.linalg.solve(second, away)))


def _with_constraints(others: System) -> Array:
    """(P, P), with a little of its own diagonal, which keeps what nothing holds out of the inverse."""
    held, stiff = others.constraint_jacobian, 1.0 / np.maximum(others.compliance, HARD)
    hessian = others.hessian + held.T @ (held * stiff[:, None])
    return np.asarray(hessian + FLOOR * np.diag(np.diag(hessian) + 1.0))
