"""The registration: match, build the terms, one damped Gauss-Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from breastrig.fitting.problem import ScanProblem, mean_distance
from breastrig.fitting.recipe import Stage, Stop
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, damped_step
from breastrig.rig.state import BodyState

__all__ = ["FitIterate", "FitTask", "fit_iterates"]


class _Stillness:
    """Counts the iterations in a row in which the mean distance hardly changed.

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
    """Share by which the stage has tightened before step number `step`: 0 to 1."""
    return min(step / max(stage.tighten - 1, 1), 1.0)


@dataclass(frozen=True, eq=False)
class InitialPoint:
    """The initial point of stages: the start, or the end of earlier stages."""

    point: BodyState
    energy: float = np.nan
    number: int = 0


def iterates(
    problem: ScanProblem, stages: Sequence[Stage] | None = None, initial: InitialPoint | None = None
) -> Iterator[FitIterate]:
    """First the start as iteration 0, then one iterate a step; the last status says why it stopped.

    Of `stages` only, where they are given, from `initial`.
    """
    recipe = problem.task.recipe
    stillness = _Stillness(recipe.stop)
    first = InitialPoint(problem.start()) if initial is None else initial
    point, energy, number = first.point, first.energy, first.number
    done = recipe.stages[-1]
    for stage in recipe.stages if stages is None else stages:
        done = stage
        free, last_stage, damping = problem.free(stage), stage is recipe.stages[-1], recipe.damping
        stillness.new_stage()
        for step_number in range(stage.iterations):
            progress = stage_progress(stage, step_number)
            matches = problem.matches(stage, progress, point)
            now = problem.iterate(number, stage, point, energy, matches, Status.RUNNING)
            is_still = stillness.reached(mean_distance(matches, np.inf), progress)
            if last_stage and is_still:
                yield replace(now, status=Status.CONVERGED)
                return
            if problem.lost(matches):
                yield replace(now, status=Status.STALLED)
                return
            yield now
            terms = problem.terms(stage, progress, point, matches)
            step = damped_step(
                problem.system(terms, point),
                partial(problem.energy, terms),
                point,
                scaling=problem.scaling,
                damping=damping,
                least_damping=recipe.damping,
                bounds=problem.bounds(point),
                free=free,
            )
            if step.status is Status.NOT_FINITE:
                yield problem.iterate(number, stage, point, energy, matches, Status.NOT_FINITE)
                return
            point, energy, damping = step.x, step.energy, step.damping
            number += 1
            if step.status is Status.STALLED and last_stage:
                yield problem.iterate(number, stage, point, energy, matches, Status.STALLED)
                return
    matches = problem.matches(done, 1.0, point)
    yield problem.iterate(number, done, point, energy, matches, Status.OUT_OF_ITERATIONS)


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    return iterates(ScanProblem(task))
