"""The registration: match, build the terms, one damped Gauss-Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.  One scan or two of the
same patient (two_stances.py) go through the same loop.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.match import Correspondences
from breastrig.fitting.problem import ScanProblem, Terms, mean_distance
from breastrig.fitting.recipe import Stage, Stop
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, System, Value, assemble, damped_step, joined_systems, value
from breastrig.least_squares.problem import Constraint
from breastrig.least_squares.quadratic_program import Bounds, joined_bounds
from breastrig.rig.parameters import RigParameters
from breastrig.rig.state import BodyState

__all__ = ["FitIterate", "FitTask", "fit_iterates"]


@dataclass(frozen=True, eq=False)
class Bodies:
    """The model on each of the scans that are fitted together: a point whose unknowns follow one another."""

    states: tuple[BodyState, ...]

    @property
    def dof(self) -> int:
        return sum(state.dof for state in self.states)

    def retract(self, step: Array) -> "Bodies":
        """The point reached along the (N,) tangent `step`."""
        steps = np.split(step, np.cumsum([state.dof for state in self.states])[:-1])
        return Bodies(tuple(state.retract(own) for state, own in zip(self.states, steps, strict=True)))


class Problem:
    """Scans of one patient that are fitted together, each with unknowns of its own; `coupling` holds them alike."""

    def __init__(self, tasks: Sequence[FitTask], coupling: Sequence[Constraint[Bodies]] = ()) -> None:
        self.recipe = tasks[0].recipe
        self.scans = tuple(ScanProblem(task) for task in tasks)
        self.scaling = np.concatenate([scan.scaling for scan in self.scans])  # (N,), see damped_step
        self._coupling = coupling

    def start(self) -> Bodies:
        return Bodies(tuple(scan.start() for scan in self.scans))

    def at(self, parameters: Sequence[RigParameters]) -> Bodies:
        """The point at which each scan's model is posed so."""
        return Bodies(tuple(BodyState(scan.task.rig, x) for scan, x in zip(self.scans, parameters, strict=True)))

    def free(self, stage: Stage) -> Booleans:
        """(N,) what the stage lets move."""
        return np.concatenate([scan.free(stage) for scan in self.scans])

    def bounds(self, point: Bodies) -> Bounds:
        """Where a step may go."""
        return joined_bounds([scan.bounds(state) for scan, state in zip(self.scans, point.states, strict=True)])

    def system(self, terms: Sequence[Terms], point: Bodies) -> System:
        """The quadratic model, with each scan's terms."""
        parts = zip(self.scans, terms, point.states, strict=True)
        own = [scan.system(of_scan, state) for scan, of_scan, state in parts]
        return joined_systems(own, assemble([], self._coupling, point))

    def value(self, terms: Sequence[Terms], point: Bodies) -> Value:
        """What is to become small."""
        parts = zip(self.scans, terms, point.states, strict=True)
        return sum((scan.value(of_scan, state) for scan, of_scan, state in parts), value([], self._coupling, point))


class _Stillness:
    """Counts the iterations in a row in which a scan's mean distance hardly changed.

    Some fits end in a cycle of two: a few vertices at a border find another partner at every other step.  That the
    distance is what it was two steps ago counts as well, for nothing more comes of it.
    """

    def __init__(self, stop: Stop) -> None:
        self._stop, self._previous, self._earlier, self._quiet = stop, np.inf, np.inf, 0

    def new_stage(self) -> None:
        self._quiet, self._previous, self._earlier = 0, np.inf, np.inf

    def reached(self, mean: float, progress: float) -> bool:
        """Whether the fit may end at this mean distance (m); only a stage that has tightened can be still."""
        change = min(abs(mean - self._previous), abs(mean - self._earlier))
        self._quiet = self._quiet + 1 if progress == 1.0 and change < self._stop.distance_change_m else 0
        self._previous, self._earlier = mean, self._previous
        return self._quiet >= self._stop.patience


def stage_progress(stage: Stage, step: int) -> float:
    """How far the stage has tightened before its step number `step`: 0 to 1."""
    return min(step / max(stage.tighten - 1, 1), 1.0)


@dataclass(frozen=True, eq=False)
class _Iteration:
    """The state of an iteration: where the model is, and what it meets there."""

    number: int
    stage: Stage
    progress: float
    point: Bodies
    energy: float
    scans: tuple[ScanProblem, ...]
    matches: tuple[Correspondences, ...]

    def terms(self) -> list[Terms]:
        """Of each scan."""
        parts = zip(self.scans, self.point.states, self.matches, strict=True)
        return [scan.terms(self.stage, self.progress, state, found) for scan, state, found in parts]

    def lost(self) -> bool:
        """Nothing holds the model on one of the scans."""
        return any(scan.lost(found) for scan, found in zip(self.scans, self.matches, strict=True))

    def reported(self, status: Status) -> tuple[FitIterate, ...]:
        """An iterate for each scan."""
        parts = zip(self.scans, self.point.states, self.matches, strict=True)
        return tuple(
            scan.iterate(self.number, self.stage, state, self.energy, found, status) for scan, state, found in parts
        )


@dataclass(frozen=True, eq=False)
class InitialPoint:
    """Where stages begin: at the start, or where earlier ones ended."""

    point: Bodies
    energy: float = np.nan
    number: int = 0


def _matched(problem: Problem, number: int, stage: Stage, progress: float, point: Bodies, energy: float) -> _Iteration:
    pairs = zip(problem.scans, point.states, strict=True)
    matches = tuple(scan.matches(stage, progress, state) for scan, state in pairs)
    return _Iteration(number, stage, progress, point, energy, problem.scans, matches)


def iterates(
    problem: Problem, stages: Sequence[Stage] | None = None, initial: InitialPoint | None = None
) -> Iterator[tuple[FitIterate, ...]]:
    """One iterate for each scan: first the start as iteration 0, then one a step; the last status says why it stopped.

    Of `stages` only, where they are given, from `initial`.  The energy in each is that of all scans
    together.
    """
    recipe = problem.recipe
    stillness = [_Stillness(recipe.stop) for _ in problem.scans]
    first = InitialPoint(problem.start()) if initial is None else initial
    point, energy, number = first.point, first.energy, first.number
    done = recipe.stages[-1]
    for stage in recipe.stages if stages is None else stages:
        done = stage
        free, last_stage, damping = problem.free(stage), stage is recipe.stages[-1], recipe.damping
        for rule in stillness:
            rule.new_stage()
        for step_number in range(stage.iterations):
            now = _matched(problem, number, stage, stage_progress(stage, step_number), point, energy)
            still = [
                rule.reached(mean_distance(found, np.inf), now.progress)
                for rule, found in zip(stillness, now.matches, strict=True)
            ]
            if last_stage and all(still):
                yield now.reported(Status.CONVERGED)
                return
            if now.lost():
                yield now.reported(Status.STALLED)
                return
            yield now.reported(Status.RUNNING)
            terms = now.terms()
            step = damped_step(
                problem.system(terms, point),
                partial(problem.value, terms),
                point,
                scaling=problem.scaling,
                damping=damping,
                least_damping=recipe.damping,
                bounds=problem.bounds(point),
                free=free,
            )
            if step.status is Status.NOT_FINITE:
                yield now.reported(Status.NOT_FINITE)
                return
            point, energy, damping = step.x, step.energy, step.damping
            number += 1
            if step.status is Status.STALLED and last_stage:
                yield replace(now, number=number, energy=energy).reported(Status.STALLED)
                return
    yield _matched(problem, number, done, 1.0, point, energy).reported(Status.OUT_OF_ITERATIONS)


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    for (iterate,) in iterates(Problem([task])):
        yield iterate
