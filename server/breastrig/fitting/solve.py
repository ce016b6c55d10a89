"""A fit to its end: started twice where breasts may hang, and without the picks that are explained by a mistake.

Where a fit's first stages have flattened breasts that hang, they are gone through once more from a start whose breasts
hang already, and the fit goes on from the better of the two (body/hanging.py).  Picks that are mistakes with a name
(picks/issues.py) are rejected after the stages that doubt picks; others that contradict the rest of the fit are only
named.  Both decide in standard deviations, never in millimetres.
"""

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace

from breastrig.fitting.body.hanging import hanging_shapes, hanging_start, opening_of, unexplained_overhang
from breastrig.fitting.fit import InitialPoint, ScanProblem, iterates
from breastrig.fitting.picks.issues import mistaken
from breastrig.fitting.recipe import Recipe, Stage
from breastrig.fitting.starts.hypotheses import Opening
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import FitIterate, FitTask, without
from breastrig.least_squares.newton import Status
from breastrig.rig.state import BodyState


def iterates_with_second_start(task: FitTask, known_opening: Opening | None = None) -> Iterator[FitIterate]:
    """The iterates as of fit_iterates; those of a second opening follow those of the first.

    `known_opening` is the whole opening of this very task, where it is known.
    """
    recipe = task.recipe
    opening = opening_of(recipe)
    if known_opening is None:
        problem = ScanProblem(task)
        first = yield from _opened(iterates(problem, opening or recipe.stages))
    else:
        problem = known_opening.problem
        first = yield from _opened(known_opening.iterates)
    if not opening or first.status is Status.NOT_FINITE:
        yield first
        return
    first = yield from _hanging(task, opening, first)
    rest = recipe.stages[len(opening) :]
    if not rest:
        yield first
        return
    before = 0.0
    if first.hanging != task.hanging:
        problem = ScanProblem(replace(task, hanging=first.hanging))  # whose clock begins now
        before = first.elapsed_s
    at = InitialPoint(BodyState(task.rig, first.parameters), first.energy, first.iteration)
    for iterate in iterates(problem, rest, at):
        yield _later(iterate, 0, before)


def _opened(opening: Iterable[FitIterate]) -> Generator[FitIterate, None, FitIterate]:
    """Yields all iterates but the last, which it returns."""
    for iterate in opening:
        if iterate.status is Status.RUNNING:
            yield iterate
    return iterate


def _hanging(task: FitTask, opening: Sequence[Stage], first: FitIterate) -> Generator[FitIterate, None, FitIterate]:
    """Returns where to go on: what has `first`, or another opening, whose iterates it yields, if that shows more."""
    settings = task.recipe.hanging
    assert settings is not None
    unexplained = unexplained_overhang(task.rig, task.target, first.parameters)
    start = hanging_start(task.rig, task.start, settings, unexplained)
    if start is task.start:
        return first
    again = replace(task, start=start, hanging=hanging_shapes(task.rig, start, task.recipe))
    for iterate in iterates(ScanProblem(again), opening):
        last = _later(iterate, first.iteration, first.elapsed_s)
        if last.status is Status.RUNNING:
            yield last
    if last.is_finite:
        left = unexplained_overhang(task.rig, task.target, last.parameters)
        if sum(left.values()) < sum(unexplained.values()):
            return last
    return replace(first, iteration=last.iteration)


def _later(iterate: FitIterate, iterations: int, seconds: float) -> FitIterate:
    return replace(iterate, iteration=iterations + iterate.iteration, elapsed_s=seconds + iterate.elapsed_s)


def checked_iterates(task: FitTask, known_opening: Opening | None = None) -> Iterator[FitIterate]:
    """The iterates as of iterates_with_second_start; those after a pick was rejected name it in `not_followed`."""
    first, rest = _parts(task.recipe)
    if not task.picked or first is None or rest is None:
        yield from iterates_with_second_start(task, known_opening)
        return
    for iterate in iterates_with_second_start(replace(task, recipe=first)):
        if iterate.status is Status.RUNNING:
            yield iterate
    if iterate.status is Status.NOT_FINITE:
        yield iterate
        return
    most = min(int(task.recipe.outliers.most * len(task.picked)), len(task.picked) - MIN_LANDMARKS)
    doubts = mistaken(task, iterate.parameters, most)
    halfway = iterate
    going_on = replace(without(task, doubts), start=halfway.parameters, recipe=rest, hanging=halfway.hanging)
    for iterate in iterates_with_second_start(going_on):
        yield replace(
            iterate,
            iteration=halfway.iteration + iterate.iteration,
            elapsed_s=halfway.elapsed_s + iterate.elapsed_s,
            not_followed=doubts,
        )


def _parts(recipe: Recipe) -> tuple[Recipe | None, Recipe | None]:
    """The stages that doubt picks, and those after them."""
    robust = [index for index, stage in enumerate(recipe.stages) if stage.doubts_picks]
    cut = robust[-1] + 1 if robust else 0
    parts = recipe.stages[:cut], recipe.stages[cut:]
    first, rest = (recipe.model_copy(update={"stages": part}) if part else None for part in parts)
    return first, rest
