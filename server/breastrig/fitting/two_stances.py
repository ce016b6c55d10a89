"""One patient in two stances, fitted together (docs/decisions/0007).

Each stance has matches and terms as in a fit of its own; one damped Gauss-Newton step moves both.  Priors of the body
count once for each stance.  Their bodies are held together by compliant constraints on the differences of bone scales
and shape weights: hard ones for ONE_BODY, springs for ALIKE, the default.  Pose and shapes of kind "gravity" belong to
each stance, in ONE_BODY those of kind "soft", too.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadSettings
from breastrig.fitting.fit import Bodies
from breastrig.fitting.starts.second_start import joint_iterates_with_second_start
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


@dataclass(frozen=True)
class Coupling:
    """Expected differences between the stances: 0 one and the same, inf apart."""

    scale: float = np.inf  # of a bone's scale
    body: float = np.inf  # of a body shape's weight, in the shape's own sigmas
    soft: float = np.inf  # of a soft shape's weight, in the shape's own sigmas; gravity shapes are never held


ONE_BODY = Coupling(scale=0.0, body=0.0)
ALIKE = Coupling(scale=0.1, body=1.0, soft=0.5)  # the best of docs/decisions/0007


def body_shapes(rig: Rig) -> Booleans:
    """(S,) which shapes are the body's, whatever the stance."""
    return np.array([shape.kind == "body" for shape in rig.shapes], dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class Alike:
    """The differences of two bodies' scales and weights as compliant constraints."""

    rig: Rig
    coupling: Coupling
    name: str = "alike"

    @cached_property
    def _sigmas(self) -> Array:
        """(P,), inf where nothing is held."""
        of_kind = {"body": self.coupling.body, "soft": self.coupling.soft, "gravity": np.inf}
        blocks = np.full((len(self.rig.bones), BONE_DOFS), np.inf)
        blocks[:, 6:9] = self.coupling.scale
        return np.concatenate([blocks.ravel(), [of_kind[shape.kind] * shape.sigma for shape in self.rig.shapes]])

    @cached_property
    def _jacobian(self) -> Array:
        """(C, 2 P)"""
        rows = np.eye(len(self._sigmas))[np.isfinite(self._sigmas)]
        return np.concatenate([rows, -rows], axis=1)

    @cached_property
    def compliance(self) -> Array:
        """(C,)"""
        return self._sigmas[np.isfinite(self._sigmas)] ** 2

    def residual(self, point: Bodies) -> Array:
        """(C,)"""
        return np.asarray(self._jacobian @ np.concatenate([_additive(state.x) for state in point.states]))

    def linearise(self, point: Bodies) -> Linearisation:
        """(C,), (C, 2 P)"""
        return Linearisation(self.residual(point), self._jacobian)


def _additive(x: RigParameters) -> Array:
    """(P,) scales and weights; 0 for the pose."""
    blocks = np.zeros((len(x.scales), BONE_DOFS))
    blocks[:, 6:9] = x.scales
    return np.concatenate([blocks.ravel(), x.weights])


@dataclass(frozen=True, eq=False)
class PairIterate:
    """One state of both stances; the energy in each is that of the two together."""

    iteration: int  # 0 is the start
    first: FitIterate
    second: FitIterate
    status: Status  # RUNNING on all but the last


def _of_one_body(first: FitTask, second: FitTask) -> tuple[FitTask, FitTask]:
    """The tasks starting with their mean body: hard constraints hold from the first iterate on."""
    shared, starts = body_shapes(first.rig), (first.start, second.start)
    scales, weights = (np.mean([getattr(each, part) for each in starts], axis=0) for part in ("scales", "weights"))

    def started(task: FitTask) -> FitTask:
        own = np.where(shared, weights, task.start.weights)
        return replace(task, start=replace(task.start, scales=scales, weights=own))

    return started(first), started(second)


def fit_pair_iterates(first: FitTask, second: FitTask, coupling: Coupling = ALIKE) -> Iterator[PairIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped.

    Raises BadSettings when the tasks differ in model or preset.
    """
    if first.rig is not second.rig:
        raise BadSettings("Two stances are fitted together with one model; give the same model for both.")
    if first.recipe != second.recipe:
        raise BadSettings("Two stances are fitted together with one preset; give the same preset for both.")
    tasks = _of_one_body(first, second) if coupling == ONE_BODY else (first, second)
    for one, other in joint_iterates_with_second_start(tasks, [Alike(first.rig, coupling)]):
        yield PairIterate(one.iteration, one, other, one.status)
