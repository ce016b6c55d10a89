"""One regularised (damped) Gauss-Newton step with constraints and bounds.

The step solves the compliant saddle system of problem.py with H = JᵀJ + μ D: Cholesky of H, then the small
Schur complement C H⁻¹ Cᵀ + K for the multipliers (136 + 48 unknowns: 0.5 ms; a dense LDLᵀ of the whole
system took three times as long).  Bounds are kept by an active set: a variable at its bound which the energy
pushes outwards is fixed, the rest is solved again (Bertsekas, Projected Newton methods, 1982).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
import scipy.linalg as sla

from breastrig.core.arrays import Array, Booleans
from breastrig.least_squares.problem import Constraint, Linearisation, ResidualTerm


class Status(Enum):
    """How an optimisation stands; the value is a sentence for people."""

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
class Bounds:
    """Bounds of the additive tangent entries, as room left from the current point."""

    lower: Array  # (P,) smallest allowed step entry, -inf where free
    upper: Array  # (P,) largest allowed step entry
    equalities: Array | None = None  # (E, P) directions along which the step must be 0 (active simplex)


@dataclass(frozen=True, eq=False)
class System:
    """Gauss-Newton's quadratic model at one point."""

    hessian: Array  # (P, P) JᵀJ
    gradient: Array  # (P,) Jᵀr
    constraint_jacobian: Array  # (C, P)
    constraint: Array  # (C,)
    compliance: Array  # (C,)
    energy: float


@dataclass(frozen=True, eq=False)
class Step(Generic[P]):
    """A step that was taken, or the reason why none was."""

    x: P
    energy: float
    damping: float
    status: Status


def energy(terms: Sequence[ResidualTerm[P]], constraints: Sequence[Constraint[P]], x: P) -> float:
    """½ Σ|r|² + ½ Σ g²/compliance; hard constraints (compliance 0) are weighed as one part in a thousand."""
    total = sum(float(r @ r) for r in (term.residual(x) for term in terms))
    for constraint in constraints:
        g = constraint.residual(x)
        total += float(g @ (g / np.maximum(constraint.compliance, 1e-6)))
    return 0.5 * total


def assemble(terms: Sequence[ResidualTerm[P]], constraints: Sequence[Constraint[P]], x: P) -> System:
    """JᵀJ and Jᵀr of all terms, and the stacked constraints."""
    size = x.dof
    hessian, gradient, total = np.zeros((size, size)), np.zeros(size), 0.0
    parts = [term.linearise(x) for term in terms]
    small = [part for part in parts if len(part.residual) < size]  # one product for all priors instead of one each
    stacked = Linearisation(
        np.concatenate([np.zeros(0)] + [part.residual for part in small]),
        np.concatenate([np.zeros((0, size))] + [part.jacobian for part in small]),
    )
    for lin in [stacked] + [part for part in parts if len(part.residual) >= size]:
        hessian += lin.jacobian.T @ lin.jacobian
        gradient += lin.jacobian.T @ lin.residual
        total += float(lin.residual @ lin.residual)
    lins = [constraint.linearise(x) for constraint in constraints]
    compliance = np.concatenate([np.zeros(0)] + [constraint.compliance for constraint in constraints])
    g = np.concatenate([np.zeros(0)] + [lin.residual for lin in lins])
    total += float(g @ (g / np.maximum(compliance, 1e-6)))
    jacobian = np.concatenate([np.zeros((0, size))] + [lin.jacobian for lin in lins])
    return System(hessian, gradient, jacobian, g, compliance, 0.5 * total)


def _positive_solve(matrix: Array, right: Array) -> Array:
    """matrix⁻¹ right by Cholesky; LinAlgError when `matrix` is not positive definite.

    LAPACK itself: SciPy's wrappers take longer to check 136 unknowns than to solve for them.
    """
    if not len(matrix):
        return right
    _, solution, info = sla.lapack.dposv(matrix, right, lower=1)
    if info > 0:
        raise sla.LinAlgError("The matrix is not positive definite.")
    return np.asarray(solution)


def _solve_free(system: System, hessian: Array, free: Booleans, fixed_step: Array, extra: Array) -> Array:
    """(P,) the step with the entries outside `free` held at `fixed_step`."""
    inside = np.flatnonzero(free)
    jacobian = np.concatenate([system.constraint_jacobian, extra])
    compliance = np.concatenate([system.compliance, np.zeros(len(extra))])
    g = np.concatenate([system.constraint, np.zeros(len(extra))]) + jacobian @ fixed_step
    gradient = (system.gradient + hessian @ fixed_step)[inside]
    c = jacobian[:, inside]
    reduced = hessian if free.all() else hessian[inside][:, inside]  # four times faster than np.ix_
    solved = _positive_solve(reduced, np.column_stack([gradient, c.T]))
    schur = c @ solved[:, 1:] + np.diag(compliance + 1e-12)
    multipliers = _positive_solve(schur, g - c @ solved[:, 0]) if len(g) else g
    step = fixed_step.copy()
    step[inside] = -solved[:, 0] - solved[:, 1:] @ multipliers
    return step


def solve_step(system: System, scaling: Array, damping: float, bounds: Bounds, free: Booleans) -> Array:
    """(P,) the damped constrained step inside the bounds; entries outside `free` stay 0."""
    hessian = system.hessian + np.diag(damping * scaling)
    extra = np.zeros((0, len(free))) if bounds.equalities is None else bounds.equalities
    fixed = np.zeros(len(free))
    movable = free.copy()
    at_wall = ((bounds.lower >= 0.0) & (system.gradient > 0.0)) | ((bounds.upper <= 0.0) & (system.gradient < 0.0))
    movable &= ~at_wall
    step = fixed
    for _ in range(6):
        step = _solve_free(system, hessian, movable, fixed, extra)
        outside = movable & ((step < bounds.lower) | (step > bounds.upper))
        if not outside.any():
            break
        fixed = np.where(outside, np.clip(step, bounds.lower, bounds.upper), fixed)
        movable &= ~outside
    return np.asarray(np.where(free, np.clip(step, bounds.lower, bounds.upper), 0.0))


def newton_step(
    terms: Sequence[ResidualTerm[P]],
    constraints: Sequence[Constraint[P]],
    x: P,
    *,
    scaling: Array,
    damping: float,
    bounds: Bounds,
    free: Booleans,
    attempts: int = 5,
) -> Step[P]:
    """One step from x: raises the damping until the energy of the same terms falls, at most `attempts` times.

    scaling: (P,) inverse square of each unknown's natural size, so that damping 1 is one standard deviation.
    """
    system = assemble(terms, constraints, x)
    return damped_step(
        system,
        lambda candidate: energy(terms, constraints, candidate),
        x,
        scaling=scaling,
        damping=damping,
        bounds=bounds,
        free=free,
        attempts=attempts,
    )


def damped_step(
    system: System,
    energy_at: Callable[[P], float],
    x: P,
    *,
    scaling: Array,
    damping: float,
    bounds: Bounds,
    free: Booleans,
    attempts: int = 5,
) -> Step[P]:
    """The same for a system that is already assembled at x."""
    if not (np.isfinite(system.energy) and np.isfinite(system.hessian).all()):
        return Step(x, system.energy, damping, Status.NOT_FINITE)
    for _ in range(attempts):
        try:
            candidate = x.retract(solve_step(system, scaling, damping, bounds, free))
        except sla.LinAlgError:
            damping *= 10.0
            continue
        after = energy_at(candidate)
        if after <= system.energy:
            return Step(candidate, after, damping, Status.RUNNING)
        damping *= 10.0
    return Step(x, system.energy, damping, Status.STALLED)
