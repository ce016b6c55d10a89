"""A fit that may begin twice: where its first stages have flattened breasts that hang, they are gone through once more
from a start whose breasts hang already, and the fit goes on from the better of the two (body/hanging_start.py).

Of two stances that are fitted together both begin again where one of them asks for it, with both breasts of that side
hanging: one that does not would pull the other flat.  What decides is what is left on both.
"""

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace

from breastrig.core.stances import SIDES
from breastrig.fitting.body.hanging_start import hanging_shapes, hanging_start, opening_of, unexplained_overhang
from breastrig.fitting.fit import Bodies, InitialPoint, Problem, iterates
from breastrig.fitting.recipe import Stage
from breastrig.fitting.starts.hypotheses import Opening
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status
from breastrig.least_squares.problem import Constraint

Iterates = tuple[FitIterate, ...]  # of each scan
Tasks = tuple[FitTask, ...]
Constraints = Sequence[Constraint[Bodies]]  # that hold bodies alike, see fit.Problem


def iterates_with_second_start(task: FitTask, known_opening: Opening | None = None) -> Iterator[FitIterate]:
    """As fit_iterates; where a second opening is gone through, its iterates follow those of the first.

    `known_opening` is the whole opening of this very task, where it is known.
    """
    known = None if known_opening is None else (known_opening.problem, [(each,) for each in known_opening.iterates])
    for (iterate,) in joint_iterates_with_second_start((task,), (), known):
        yield iterate


def joint_iterates_with_second_start(
    tasks: Tasks, coupling: Constraints = (), known_opening: tuple[Problem, Sequence[Iterates]] | None = None
) -> Iterator[Iterates]:
    """The same of scans that are fitted together."""
    recipe = tasks[0].recipe
    opening = opening_of(recipe)
    if known_opening is None:
        problem = Problem(tasks, coupling)
        first = yield from _opened(iterates(problem, opening or recipe.stages))
    else:
        problem = known_opening[0]
        first = yield from _opened(known_opening[1])
    if not opening or first[0].status is Status.NOT_FINITE:
        yield first
        return
    first = yield from _hanging(tasks, coupling, opening, first)
    rest = recipe.stages[len(opening) :]
    if not rest:
        yield first
        return
    before = 0.0
    if any(each.hanging != task.hanging for each, task in zip(first, tasks, strict=True)):
        problem = Problem(_expecting(tasks, [each.hanging for each in first]), coupling)  # whose clock begins now
        before = first[0].elapsed_s
    at = InitialPoint(problem.at([each.parameters for each in first]), first[0].energy, first[0].iteration)
    for iterate in iterates(problem, rest, at):
        yield _later(iterate, 0, before)


def _opened(opening: Iterable[Iterates]) -> Generator[Iterates, None, Iterates]:
    """Yields all iterates but the last, which it returns."""
    for iterate in opening:
        if iterate[0].status is Status.RUNNING:
            yield iterate
    return iterate


def _hanging(
    tasks: Tasks, coupling: Constraints, opening: Sequence[Stage], first: Iterates
) -> Generator[Iterates, None, Iterates]:
    """Returns where to go on: what has `first`, or another opening, whose iterates it yields, if that shows more."""
    settings = tasks[0].recipe.hanging
    assert settings is not None
    unexplained = [_unexplained(task, each) for task, each in zip(tasks, first, strict=True)]
    most = {side: max(shares.get(side, 0.0) for shares in unexplained) for side in SIDES}
    starts = [hanging_start(task.rig, task.start, settings, most) for task in tasks]
    if all(start is task.start for start, task in zip(starts, tasks, strict=True)):
        return first
    again = _expecting(tasks, [hanging_shapes(t.rig, x, t.recipe) for t, x in zip(tasks, starts, strict=True)])
    again = tuple(replace(task, start=start) for task, start in zip(again, starts, strict=True))
    for iterate in iterates(Problem(again, coupling), opening):
        last = _later(iterate, first[0].iteration, first[0].elapsed_s)
        if last[0].status is Status.RUNNING:
            yield last
    if all(each.is_finite for each in last):
        left = [_unexplained(task, each) for task, each in zip(tasks, last, strict=True)]
        if _all(left) < _all(unexplained):
            return last
    return tuple(replace(each, iteration=last[0].iteration) for each in first)


def _unexplained(task: FitTask, iterate: FitIterate) -> dict[str, float]:
    return unexplained_overhang(task.rig, task.target, iterate.parameters)


def _later(iterate: Iterates, iterations: int, seconds: float) -> Iterates:
    return tuple(
        replace(each, iteration=iterations + each.iteration, elapsed_s=seconds + each.elapsed_s) for each in iterate
    )


def _expecting(tasks: Tasks, hanging: Sequence[tuple[str, ...]]) -> Tasks:
    return tuple(replace(task, hanging=names) for task, names in zip(tasks, hanging, strict=True))


def _all(unexplained: Sequence[dict[str, float]]) -> float:
    return sum(sum(shares.values()) for shares in unexplained)
