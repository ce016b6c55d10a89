"""One regularised (damped) Gauss-Newton step with constraints and bounds.

The step d minimises the damped quadratic model within the bounds (quadratic_program.py):

    m(d) = E + gᵀd + ½ dᵀ (H + μ D) d,    H = JᵀJ + Cᵀ K⁻¹ C,    hard constraints: C d = −c

It is taken when the energy falls by a fair share of what the model without damping promises (the gain ratio); the
ratio also says how far the model is to be trusted next time, which is the damping μ (Marquardt 1963; Nocedal and
Wright, Numerical Optimization, 2006, algorithms 4.1 and 18.3).  Where there are hard constraints, ν Σ|c| is added
to the energy that must fall, with ν above the largest multiplier, so that meeting them may cost energy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.linalg import LinAlgError
from scipy.linalg import block_diag

from breastrig.core.arrays import Array, Booleans
from breastrig.least_squares.problem import HARD, Constraint, ResidualTerm, StructuredTerm
from breastrig.least_squares.quadratic_program import Bounds, minimiser

ACCEPTED = 0.1  # gain ratio of a step that is taken; below it the model is wrong, not merely rough
POOR, GOOD = 0.25, 0.75  # gain ratios below and above which the damping changes (Nocedal and Wright, algorithm 4.1)
STRONGER, WEAKER = 4.0, 1.0 / 3.0  # changes of the damping after a poor and a good step
AFTER_REJECTION = 10.0  # change of the damping when a step is not taken ...
ATTEMPTS = 8  # ... so often: from the smallest damping of a preset to steps of a thousandth of a standard deviation
PENALTY = 2.0  # times the largest multiplier: any value above 1 makes the step a descent direction
ROUNDING = 1e-12  # of the energy; a smaller promise cannot be checked


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


@dataclass(frozen=True)
class Value:
    """What is to become small at a point."""

    energy: float  # ½ Σ|r|² + ½ Σ c²/compliance, without the hard constraints
    violation: float = 0.0  # Σ|c| of the hard constraints

    def __add__(self, other: "Value") -> "Value":
        return Value(self.energy + other.energy, self.violation + other.violation)


@dataclass(frozen=True, eq=False)
class System:
    """Gauss-Newton's quadratic model at one point."""

    hessian: Array  # (P, P) JᵀJ of the terms
    gradient: Array  # (P,) Jᵀr of the terms
    constraint_jacobian: Array  # (C, P)
    constraint: Array  # (C,)
    compliance: Array  # (C,)
    energy: float  # as in Value


@dataclass(frozen=True, eq=False)
class Step(Generic[P]):
    """A step that was taken, or the reason why none was."""

    x: P
    energy: float
    damping: float  # to begin the next step with
    status: Status


def _value(residuals: Sequence[Array], constraints: Array, compliance: Array) -> Value:
    hard = compliance <= HARD
    elastic = constraints[~hard]
    total = sum(float(r @ r) for r in residuals) + float(elastic @ (elastic / compliance[~hard]))
    return Value(0.5 * total, float(np.abs(constraints[hard]).sum()))


def _joined(parts: Sequence[Array]) -> Array:
    return np.concatenate([np.zeros(0), *parts])


def value(terms: Sequence[ResidualTerm[P]], constraints: Sequence[Constraint[P]], x: P) -> Value:
    """Energy and violation at x."""
    violations = _joined([constraint.residual(x) for constraint in constraints])
    compliance = _joined([constraint.compliance for constraint in constraints])
    return _value([term.residual(x) for term in terms], violations, compliance)


def assemble(terms: Sequence[ResidualTerm[P]], constraints: Sequence[Constraint[P]], x: P) -> System:
    """JᵀJ and Jᵀr of all terms, and the stacked constraints."""
    size = x.dof
    hessian, gradient, energy = np.zeros((size, size)), np.zeros(size), 0.0
    structured = [term for term in terms if isinstance(term, StructuredTerm)]
    for term in structured:
        part = term.normal_equations(x)
        hessian += part.hessian
        gradient += part.gradient
        energy += part.energy
    dense = [term.linearise(x) for term in terms if not isinstance(term, StructuredTerm)]
    if dense:  # one product for all of them
        residual = np.concatenate([lin.residual for lin in dense])
        jacobian = np.concatenate([lin.jacobian for lin in dense])
        hessian += jacobian.T @ jacobian
        gradient += residual @ jacobian
        energy += 0.5 * float(residual @ residual)
    lins = [constraint.linearise(x) for constraint in constraints]
    compliance = _joined([constraint.compliance for constraint in constraints])
    violations = _joined([lin.residual for lin in lins])
    rows = np.concatenate([np.zeros((0, size))] + [lin.jacobian for lin in lins])
    energy += _value([], violations, compliance).energy
    return System(hessian, gradient, rows, violations, compliance, energy)


def joined_systems(parts: Sequence[System], coupling: System) -> System:
    """Of unknowns that follow one another, and what holds them together."""
    fields = ("gradient", "constraint", "compliance")
    gradient, constraint, compliance = (np.concatenate([getattr(part, each) for part in parts]) for each in fields)
    return System(
        block_diag(*(part.hessian for part in parts)) + coupling.hessian,
        gradient + coupling.gradient,
        np.concatenate([block_diag(*(part.constraint_jacobian for part in parts)), coupling.constraint_jacobian]),
        np.concatenate([constraint, coupling.constraint]),
        np.concatenate([compliance, coupling.compliance]),
        sum(part.energy for part in parts) + coupling.energy,
    )


@dataclass(frozen=True, eq=False)
class _Model:
    """The quadratic model in the unknowns that may move, its elastic constraints added to the energy."""

    hessian: Array  # (N, N)
    gradient: Array  # (N,)
    hard_jacobian: Array  # (E, N)
    hard: Array  # (E,)

    @staticmethod
    def of(system: System, free: Booleans) -> "_Model":
        hard = system.compliance <= HARD
        root = 1.0 / np.sqrt(system.compliance[~hard])
        elastic = system.constraint_jacobian[~hard] * root[:, None]
        hessian = system.hessian + elastic.T @ elastic
        gradient = system.gradient + elastic.T @ (system.constraint[~hard] * root)
        rows = system.constraint_jacobian[hard]
        if not free.all():
            hessian, gradient, rows = hessian[free][:, free], gradient[free], rows[:, free]
        moved = rows.any(axis=1)  # the others hold what may not move
        return _Model(hessian, gradient, rows[moved], system.constraint[hard][moved])

    def step(self, damping: Array, bounds: Bounds) -> tuple[Array, Array]:
        """((N,) the damped step within the bounds, (E,) multipliers of the hard constraints); damping: (N,) μ D."""
        damped = self.hessian.copy()
        damped.flat[:: len(damped) + 1] += damping
        return minimiser(damped, self.gradient, bounds, self.hard_jacobian, -self.hard)

    def promise(self, step: Array) -> float:
        """By how much the energy falls if the model is right."""
        return -float(self.gradient @ step + 0.5 * step @ (self.hessian @ step))

    def violation(self, step: Array) -> float:
        """Σ|c| after the step if the model is right."""
        return float(np.abs(self.hard + self.hard_jacobian @ step).sum())


def _movable(bounds: Bounds, free: Booleans) -> Bounds:
    """The bounds of the unknowns that may move."""
    if free.all():
        return bounds
    rows = None if bounds.rows is None else bounds.rows[:, free]
    return Bounds(bounds.lower[free], bounds.upper[free], rows, bounds.row_limits)


def newton_step(
    terms: Sequence[ResidualTerm[P]],
    constraints: Sequence[Constraint[P]],
    x: P,
    *,
    scaling: Array,
    damping: float,
    least_damping: float,
    bounds: Bounds,
    free: Booleans,
    attempts: int = ATTEMPTS,
) -> Step[P]:
    """One step from x, at most `attempts` tries; entries outside `free` (P,) stay where they are.

    scaling: (P,) inverse square of each unknown's natural size, so that damping 1 is one standard deviation.
    damping: of the first try, from the step before; least_damping: how far a good model may lower it.
    """
    return damped_step(
        assemble(terms, constraints, x),
        lambda candidate: value(terms, constraints, candidate),
        x,
        scaling=scaling,
        damping=damping,
        least_damping=least_damping,
        bounds=bounds,
        free=free,
        attempts=attempts,
    )


def damped_step(
    system: System,
    value_at: Callable[[P], Value],
    x: P,
    *,
    scaling: Array,
    damping: float,
    least_damping: float,
    bounds: Bounds,
    free: Booleans,
    attempts: int = ATTEMPTS,
) -> Step[P]:
    """The same for a system that is already assembled at x."""
    if not (np.isfinite(system.energy) and np.isfinite(system.hessian).all()):
        return Step(x, system.energy, damping, Status.NOT_FINITE)
    model, room = _Model.of(system, free), _movable(bounds, free)
    before = Value(system.energy, float(np.abs(model.hard).sum()))
    tried = damping
    for _ in range(attempts):
        try:
            moves, multipliers = model.step(tried * scaling[free], room)
        except LinAlgError:
            tried *= AFTER_REJECTION
            continue
        step = np.zeros(len(free))
        step[free] = moves
        candidate = x.retract(step)
        after = value_at(candidate)
        penalty = PENALTY * float(np.abs(multipliers).max(initial=0.0))
        promised = model.promise(moves) + penalty * (before.violation - model.violation(moves))
        gained = before.energy - after.energy + penalty * (before.violation - after.violation)
        if abs(promised) <= ROUNDING * before.energy and np.isfinite(after.energy):
            return Step(candidate, after.energy, tried, Status.RUNNING)
        ratio = gained / promised if promised > 0.0 else -np.inf
        if ratio >= ACCEPTED:
            change = STRONGER if ratio < POOR else WEAKER if ratio > GOOD else 1.0
            return Step(candidate, after.energy, max(change * tried, least_damping), Status.RUNNING)
        tried *= AFTER_REJECTION
    return Step(x, system.energy, damping, Status.STALLED)
