"""A fit that may begin twice: where its first stages have flattened breasts that hang, they are gone through once more
from a start whose breasts hang already, and the fit goes on from the better of the two (body/hanging_start.py)."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace

from breastrig.fitting.body.hanging_start import hanging_shapes, hanging_start, opening_of, unexplained_overhang
from breastrig.fitting.fit import Begun, OneScan, iterates
from breastrig.fitting.problem import ScanProblem
from breastrig.fitting.recipe import Stage
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status
from breastrig.rig.state import BodyState


def opened_iterates(task: FitTask) -> Iterator[FitIterate]:
    """As fit_iterates; where a second opening is gone through, its iterates follow those of the first."""
    problem, opening = OneScan(ScanProblem(task)), opening_of(task.recipe)
    begun = yield from _opened(problem, opening or task.recipe.stages)
    if not opening or begun.status is Status.NOT_FINITE:
        yield begun
        return
    begun = yield from _hanging(task, opening, begun)
    rest = task.recipe.stages[len(opening) :]
    if not rest:
        yield begun
        return
    at = Begun(BodyState(task.rig, begun.parameters), begun.energy, begun.iteration)
    before = 0.0
    if begun.hanging != task.hanging:  # another prior, whose clock begins now
        problem, before = OneScan(ScanProblem(replace(task, hanging=begun.hanging))), begun.elapsed_s
    for (iterate,) in iterates(problem, rest, at):
        yield replace(iterate, elapsed_s=before + iterate.elapsed_s)


def _opened(problem: OneScan, opening: Sequence[Stage]) -> Generator[FitIterate, None, FitIterate]:
    """Yields all iterates but the last, which it returns."""
    for (iterate,) in iterates(problem, opening):
        if iterate.status is Status.RUNNING:
            yield iterate
    return iterate


def _hanging(task: FitTask, opening: Sequence[Stage], begun: FitIterate) -> Generator[FitIterate, None, FitIterate]:
    """Returns where to go on: what has `begun`, or another opening, whose iterates it yields, if that shows more."""
    rig, settings = task.rig, task.recipe.hanging
    assert settings is not None
    unexplained = unexplained_overhang(rig, task.target, begun.parameters)
    start = hanging_start(rig, task.start, settings, unexplained)
    if start is task.start:
        return begun
    hanging = hanging_shapes(rig, start, task.recipe)
    for (iterate,) in iterates(OneScan(ScanProblem(replace(task, start=start, hanging=hanging))), opening):
        number, elapsed = begun.iteration + iterate.iteration, begun.elapsed_s + iterate.elapsed_s
        again = replace(iterate, iteration=number, elapsed_s=elapsed)
        if iterate.status is Status.RUNNING:
            yield again
    left = unexplained_overhang(rig, task.target, again.parameters) if again.is_finite else unexplained
    better = sum(left.values()) < sum(unexplained.values())
    return again if better else replace(begun, iteration=again.iteration)
