"""One patient in two stances, fitted together (docs/decisions/0007).

Each stance has matches and terms as in a fit of its own; the normal equations are added up, and one damped Gauss-Newton
step moves both.  Priors of the body count once for each stance.  ONE_BODY shares bone scales and body shapes:

    [ first stance's P entries, the body among them | second stance's entries without the body ]

ALIKE, the default, gives each its own, with springs on the differences d: ½ Σ (d/σ)².  Pose and shapes of kind "soft"
and "gravity" belong to each stance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadSettings
from breastrig.fitting.problem import ScanProblem, Terms
from breastrig.fitting.recipe import Recipe, Stage
from breastrig.fitting.starts.second_start import joint_iterates_with_second_start
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, System, Value
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.state import BodyState


@dataclass(frozen=True)
class Coupling:
    """exact: one body; otherwise the expected differences between the stances (inf: apart)."""

    exact: bool
    scale: float = np.inf  # of a bone's scale
    body: float = np.inf  # of a body shape's weight, in the shape's own sigmas
    soft: float = np.inf  # of a soft shape's weight, in the shape's own sigmas; gravity shapes are never held


ONE_BODY = Coupling(exact=True)
ALIKE = Coupling(exact=False, scale=0.1, body=1.0, soft=0.5)  # the best of docs/decisions/0007


@dataclass(frozen=True, eq=False)
class SharedBody:
    """Which of a stance's P entries are the body's, and where the second stance's entries stand."""

    rig: Rig
    exact: bool = True  # False: nothing stands once, each stance has a body of its own

    @cached_property
    def body_shapes(self) -> Booleans:
        """(S,)"""
        return np.array([shape.kind == "body" for shape in self.rig.shapes], dtype=np.bool_)

    @cached_property
    def shared(self) -> Booleans:
        """(P,)"""
        bones = len(self.rig.bones)
        blocks = np.zeros((bones, BONE_DOFS), dtype=np.bool_)
        blocks[:, 6:9] = True
        return np.concatenate([blocks.ravel(), self.body_shapes]) & self.exact

    @cached_property
    def second(self) -> Integers:
        """(P,) place of each of the second stance's entries in the vector of both."""
        places = np.arange(len(self.shared))
        own = np.flatnonzero(~self.shared)
        places[own] = len(self.shared) + np.arange(len(own))
        return places

    @property
    def size(self) -> int:
        """N, the length of the vector of both."""
        return len(self.shared) + int((~self.shared).sum())

    def added(self, first: Array, second: Array) -> Array:
        """(N,) of two (P,): the body's entries are added up."""
        result = np.zeros(self.size)
        result[: len(first)] = first
        result[self.second] += second
        return result

    def system(self, first: System, second: System) -> System:
        """Both stances' Gauss-Newton models as one; each keeps its own constraints."""
        size, own = self.size, len(self.shared)
        hessian = np.zeros((size, size))
        hessian[:own, :own] = first.hessian
        hessian[np.ix_(self.second, self.second)] += second.hessian
        constraints = len(first.constraint)
        jacobian = np.zeros((constraints + len(second.constraint), size))
        jacobian[:constraints, :own] = first.constraint_jacobian
        jacobian[constraints:, self.second] = second.constraint_jacobian
        return System(
            hessian,
            self.added(first.gradient, second.gradient),
            jacobian,
            np.concatenate([first.constraint, second.constraint]),
            np.concatenate([first.compliance, second.compliance]),
            first.energy + second.energy,
        )

    def bounds(self, first: Bounds, second: Bounds) -> Bounds:
        """What both stances allow."""
        size, own = self.size, len(self.shared)
        lower, upper = np.full(size, -np.inf), np.full(size, np.inf)
        lower[:own], upper[:own] = first.lower, first.upper
        lower[self.second] = np.maximum(lower[self.second], second.lower)
        upper[self.second] = np.minimum(upper[self.second], second.upper)
        rows, limits = [], []
        for one, places in ((first, np.arange(own)), (second, self.second)):
            if one.rows is not None and one.row_limits is not None:
                row = np.zeros((len(one.rows), size))
                row[:, places] = one.rows
                rows.append(row)
                limits.append(one.row_limits)
        return Bounds(lower, upper, np.concatenate(rows), np.concatenate(limits)) if rows else Bounds(lower, upper)

    def free(self, own: Booleans) -> Booleans:
        """(N,) of the (P,) entries that a stage lets move in either stance."""
        result = np.zeros(self.size, dtype=np.bool_)
        result[: len(own)] = own
        result[self.second] = own
        return result

    def agreed(self, first: BodyState, second: BodyState) -> "TwoStances":
        """Two stances with their mean body; as they are when each has its own."""
        if not self.exact:
            return TwoStances(first, second, self)
        scales, weights = 0.5 * (first.x.scales + second.x.scales), 0.5 * (first.x.weights + second.x.weights)

        def with_body(x: RigParameters) -> BodyState:
            return BodyState(
                self.rig, replace(x, scales=scales, weights=np.where(self.body_shapes, weights, x.weights))
            )

        return TwoStances(with_body(first.x), with_body(second.x), self)


@dataclass(frozen=True, eq=False)
class TwoStances:
    """A point on the manifold of both stances; the body's values are the same to the last bit."""

    first: BodyState
    second: BodyState
    layout: SharedBody

    @property
    def dof(self) -> int:
        return self.layout.size

    def retract(self, step: Array) -> "TwoStances":
        """The point reached along the (N,) tangent `step`."""
        return TwoStances(
            self.first.retract(step[: self.first.dof]), self.second.retract(step[self.layout.second]), self.layout
        )


class Springs:
    """The energy of the differences, for the layout of both stances."""

    def __init__(self, rig: Rig, coupling: Coupling, layout: SharedBody) -> None:
        sigma = {"body": coupling.body, "soft": coupling.soft, "gravity": np.inf}
        scales = np.zeros((len(rig.bones), BONE_DOFS))
        scales[:, 6:9] = coupling.scale**-2
        shapes = np.array([(sigma[shape.kind] * shape.sigma) ** -2 for shape in rig.shapes])
        self._stiffness = np.concatenate([scales.ravel(), shapes])  # (P,)
        self._second = layout.second

    def energy(self, point: TwoStances) -> float:
        return 0.5 * float(self._stiffness @ self._difference(point) ** 2)

    def added_to(self, system: System, point: TwoStances) -> System:
        """The quadratic model with the springs' own."""
        first, second, k = np.arange(len(self._second)), self._second, self._stiffness
        hessian, gradient = system.hessian.copy(), system.gradient.copy()
        pull = k * self._difference(point)
        gradient[first] += pull
        gradient[second] -= pull
        hessian[first, first] += k
        hessian[second, second] += k
        hessian[first, second] -= k
        hessian[second, first] -= k
        return System(
            hessian,
            gradient,
            system.constraint_jacobian,
            system.constraint,
            system.compliance,
            system.energy + self.energy(point),
        )

    def _difference(self, point: TwoStances) -> Array:
        """(P,) of the additive entries; 0 for the pose."""
        return _additive(point.first.x) - _additive(point.second.x)


def _additive(x: RigParameters) -> Array:
    blocks = np.zeros((len(x.scales), BONE_DOFS))
    blocks[:, 6:9] = x.scales
    return np.concatenate([blocks.ravel(), x.weights])


class _TwoScans:
    """The problem of two scans (see fit.py)."""

    def __init__(self, first: FitTask, second: FitTask, coupling: Coupling) -> None:
        self.recipe: Recipe = first.recipe
        self.scans: tuple[ScanProblem, ...] = (ScanProblem(first), ScanProblem(second))
        self._layout = SharedBody(first.rig, coupling.exact)
        self._springs = Springs(first.rig, coupling, self._layout)
        self.scaling: Array = self._layout.added(self.scans[0].scaling, self.scans[1].scaling)

    def start(self) -> TwoStances:
        return self._layout.agreed(self.scans[0].start(), self.scans[1].start())

    def at(self, parameters: Sequence[RigParameters]) -> TwoStances:
        first, second = (BodyState(scan.task.rig, x) for scan, x in zip(self.scans, parameters, strict=True))
        return self._layout.agreed(first, second)

    def states(self, point: TwoStances) -> tuple[BodyState, ...]:
        return point.first, point.second

    def free(self, stage: Stage) -> Booleans:
        return self._layout.free(self.scans[0].free(stage))

    def bounds(self, point: TwoStances) -> Bounds:
        return self._layout.bounds(self.scans[0].bounds(point.first), self.scans[1].bounds(point.second))

    def system(self, terms: Sequence[Terms], point: TwoStances) -> System:
        first = self.scans[0].system(terms[0], point.first)
        second = self.scans[1].system(terms[1], point.second)
        return self._springs.added_to(self._layout.system(first, second), point)

    def value(self, terms: Sequence[Terms], point: TwoStances) -> Value:
        first = self.scans[0].value(terms[0], point.first)
        return first + self.scans[1].value(terms[1], point.second) + Value(self._springs.energy(point))


@dataclass(frozen=True, eq=False)
class PairIterate:
    """One state of both stances; the energy in each is that of the two together."""

    iteration: int  # 0 is the start
    first: FitIterate
    second: FitIterate
    status: Status  # RUNNING on all but the last


def fit_pair_iterates(first: FitTask, second: FitTask, coupling: Coupling = ALIKE) -> Iterator[PairIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped.

    Raises BadSettings when the tasks differ in model or preset.
    """
    if first.rig is not second.rig:
        raise BadSettings("Two stances are fitted together with one model; give the same model for both.")
    if first.recipe != second.recipe:
        raise BadSettings("Two stances are fitted together with one preset; give the same preset for both.")
    for one, other in joint_iterates_with_second_start(
        (first, second), lambda tasks: _TwoScans(tasks[0], tasks[1], coupling)
    ):
        yield PairIterate(one.iteration, one, other, one.status)
