"""One regularised (damped) Gauss-Newton step within bounds.

The step d minimises the damped quadratic model within the bounds (quadratic_program.py):

    m(d) = E + gᵀd + ½ dᵀ (H + μ D) d,    H = JᵀJ

It is taken when the energy falls by a fair share of what the model without damping promises (the gain ratio); the
ratio also says how far the model is to be trusted next time, which is the damping μ (Marquardt 1963; Nocedal and
Wright, Numerical Optimization, 2006, algorithm 4.1).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import groupby
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.linalg import LinAlgError

from breastrig.core.arrays import Array, Booleans
from breastrig.least_squares.problem import NormalEquations, ResidualTerm, StructuredTerm
from breastrig.least_squares.quadratic_program import Bounds, minimiser

ACCEPTED = 0.1  # gain ratio of a step that is taken; below it the model is wrong, not merely rough
POOR, GOOD = 0.25, 0.75  # gain ratios below and above which the damping changes (Nocedal and Wright, algorithm 4.1)
STRONGER, WEAKER = 4.0, 1.0 / 3.0  # changes of the damping after a poor and a good step
AFTER_REJECTION = 10.0  # change of the damping when a step is not taken ...
ATTEMPTS = 8  # ... so often: from the smallest damping of a preset to steps of a thousandth of a standard deviation
ROUNDING = 1e-12  # of the energy; a smaller promise cannot be checked


class Status(Enum):
    """The state of an optimisation; the value is a sentence for people."""

    RUNNING = "The fit is running."
    CONVERGED = "Converged: the mean distance no longer changes."
    OUT_OF_ITERATIONS = "Stopped at the iteration limit."
    STALLED = "Stopped: no step lowers the energy."
    NOT_FINITE = "Stopped: a number is not finite."
    CANCELLED = "The fit was cancelled."


class Point(Protocol):
    """A point on a manifold."""

    @property
    def dof(self) -> int: ...

    def retract(self, step: Array, /) -> Self:
        """The point reached along a tangent step."""


P = TypeVar("P", bound=Point)


@dataclass(frozen=True, eq=False)
class System:
    """Gauss-Newton's quadratic model at one point."""

    hessian: Array  # (P, P) JᵀJ
    gradient: Array  # (P,) Jᵀr
    energy: float  # ½ Σ|r|²


@dataclass(frozen=True, eq=False)
class Step(Generic[P]):
    """A step that was taken, or the reason why none was."""

    x: P
    energy: float
    damping: float  # to begin the next step with
    status: Status


def energy_of(terms: Sequence[ResidualTerm[P]], x: P) -> float:
    """½ Σ|r|² at x."""
    residuals = [term.residual(x) for term in terms]
    return 0.5 * sum(float(r @ r) for r in residuals)


def assemble(terms: Sequence[ResidualTerm[P]], x: P) -> System:
    """JᵀJ and Jᵀr of all terms; of those that follow one another without a structure by one product."""
    size = x.dof
    hessian, gradient, energy = np.zeros((size, size)), np.zeros(size), 0.0
    for is_structured, group in groupby(terms, lambda term: isinstance(term, StructuredTerm)):
        together = list(group)
        structured = [term.normal_equations(x) for term in together if isinstance(term, StructuredTerm)]
        for part in structured if is_structured else [_stacked(together, x)]:
            own = len(part.gradient)  # a term may know of the first unknowns only
            hessian[:own, :own] += part.hessian
            gradient[:own] += part.gradient
            energy += part.energy
    return System(hessian, gradient, energy)


def _stacked(terms: Sequence[ResidualTerm[P]], x: P) -> NormalEquations:
    found = [term.linearise(x) for term in terms]
    residual = np.concatenate([each.residual for each in found])
    jacobian = np.concatenate([wide(each.jacobian, x.dof) for each in found])
    return NormalEquations(jacobian.T @ jacobian, residual @ jacobian, 0.5 * float(residual @ residual))


def wide(jacobian: Array, unknowns: int) -> Array:
    """(M, P): a Jacobian with respect to the first of P unknowns, with zeros for the others."""
    more = unknowns - jacobian.shape[1]
    return np.pad(jacobian, ((0, 0), (0, more))) if more else jacobian


def damped_step(
    system: System,
    energy_at: Callable[[P], float],
    x: P,
    *,
    scaling: Array,
    damping: float,
    least_damping: float,
    bounds: Bounds,
    free: Booleans,
) -> Step[P]:
    """One step from x, at which `system` is assembled, at most ATTEMPTS tries; entries outside `free` (P,) stay.

    scaling: (P,) inverse square of each unknown's natural size, so that damping 1 is one standard deviation.
    damping: of the first try, from the step before; least_damping: how far a good model may lower it.
    """
    hessian, gradient = system.hessian, system.gradient
    room = bounds if free.all() else Bounds(bounds.lower[free], bounds.upper[free])
    if not (np.isfinite(system.energy) and np.isfinite(hessian).all()):
        return Step(x, system.energy, damping, Status.NOT_FINITE)
    if not free.all():
        hessian, gradient = hessian[free][:, free], gradient[free]
    tried = damping
    for _ in range(ATTEMPTS):
        damped = hessian.copy()
        damped.flat[:: len(damped) + 1] += tried * scaling[free]
        try:
            moves = minimiser(damped, gradient, room)
        except LinAlgError:
            tried *= AFTER_REJECTION
            continue
        step = np.zeros(len(free))
        step[free] = moves
        candidate = x.retract(step)
        energy = energy_at(candidate)
        promised = -float(gradient @ moves + 0.5 * moves @ (hessian @ moves))
        if abs(promised) <= ROUNDING * system.energy and np.isfinite(energy):
            return Step(candidate, energy, tried, Status.RUNNING)
        ratio = (system.energy - energy) / promised if promised > 0.0 else -np.inf
        if ratio >= ACCEPTED:
            change = STRONGER if ratio < POOR else WEAKER if ratio > GOOD else 1.0
            return Step(candidate, energy, max(change * tried, least_damping), Status.RUNNING)
        tried *= AFTER_REJECTION
    return Step(x, system.energy, damping, Status.STALLED)
