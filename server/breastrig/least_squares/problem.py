"""The parts of a least-squares problem.

Energy E(x) = ½ Σ_terms |r(x)|², every residual divided by its expected size, so that 1 means one standard deviation. An
equation g(x) = 0 with a compliance (Tournier et al., Stable constrained dynamics, 2015; reference 30 of the paper) is a
residual like any other, with the root of the compliance as its sigma.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np

from breastrig.core.arrays import Array

X_contra = TypeVar("X_contra", contravariant=True)


@dataclass(frozen=True, eq=False)
class Linearisation:
    """A residual and its derivative at one point."""

    residual: Array  # (M,)
    jacobian: Array  # (M, P) with respect to the tangent step


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """A residual's contribution to Gauss-Newton's quadratic model at one point."""

    hessian: Array  # (P, P) JᵀJ
    gradient: Array  # (P,) Jᵀr
    energy: float  # ½ |r|²


class ResidualTerm(Protocol[X_contra]):
    """One source of residuals."""

    @property
    def name(self) -> str: ...

    def residual(self, x: X_contra) -> Array:
        """(M,) in standard deviations."""

    def linearise(self, x: X_contra) -> Linearisation:
        """The residual with its Jacobian."""


class StructuredTerm(ABC, Generic[X_contra]):
    """Base class of residual terms that need no Jacobian for their normal equations."""

    @abstractmethod
    def normal_equations(self, x: X_contra, /) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|², equal to those of `linearise`."""


class ConstantTerm(StructuredTerm[X_contra]):
    """Base class of residual terms that are linear in the step: JᵀJ is formed once."""

    @abstractmethod
    def residual(self, x: X_contra, /) -> Array:
        """(M,)"""

    @abstractmethod
    def slope(self) -> Array:
        """(M, P) the Jacobian, computed anew."""

    @cached_property
    def _constant(self) -> tuple[Array, Array]:
        jacobian = self.slope()
        jacobian.flags.writeable = False
        return jacobian, jacobian.T @ jacobian

    def linearise(self, x: X_contra, /) -> Linearisation:
        """(M,), (M, P)"""
        return Linearisation(self.residual(x), self._constant[0])

    def normal_equations(self, x: X_contra, /) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|²"""
        (jacobian, hessian), residual = self._constant, self.residual(x)
        return NormalEquations(hessian, residual @ jacobian, 0.5 * float(residual @ residual))


def inlier_chance(r: Array, even: Array | float | None) -> Array:
    """Chance that an observation r standard deviations off belongs to what it is compared with: one half at `even`.

    Of a Gaussian and a uniform density beside it; None: there are no others.  This is the weight of iteratively
    reweighted least squares (the E-step; Dempster, Laird and Rubin, 1977).
    """
    if even is None:
        return np.ones_like(r)
    return np.asarray(1.0 / (1.0 + np.exp(np.minimum(0.5 * (r * r - even * even), 500.0))))


def mixture_cost(r: Array, even: float | None) -> Array:
    """Minus the logarithm of that mixture's density at r, 0 at r = 0; at most outlier_cost(even)."""
    if even is None:
        return np.asarray(0.5 * r * r)
    floor = -0.5 * even * even
    return np.asarray(np.logaddexp(0.0, floor) - np.logaddexp(-0.5 * r * r, floor))


def outlier_cost(even: float) -> float:
    """The cost of a rejected observation."""
    return float(np.logaddexp(0.0, -0.5 * even * even)) + 0.5 * even * even


FREEDOM = 4.0  # degrees, of a Student t, as landmarks' errors were estimated with (docs/decisions/0028)


def log_student(deviations: Array | float, axes: int) -> Array:
    """Nats, of a Student t over so many axes, beside its density at the mean."""
    return np.asarray(-0.5 * (FREEDOM + axes) * np.log1p(np.square(deviations) / FREEDOM))
