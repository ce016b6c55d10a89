"""A fit that follows all picks except those explained by a mistake with a name (mistakes.py).

They are rejected after the stages that doubt picks; other picks that contradict
the rest of the fit are only named (unusual.py).  Both decide in standard deviations, never in millimetres.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from breastrig.fitting.picks.mistakes import mistaken
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.starts.hypotheses import Opening
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.starts.second_start import iterates_with_second_start
from breastrig.fitting.task import FitIterate, FitTask, PickIssue
from breastrig.least_squares.newton import Status


def checked_iterates(task: FitTask, known_opening: Opening | None = None) -> Iterator[FitIterate]:
    """As iterates_with_second_start; iterates after a pick was rejected name it in `not_followed`."""
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


def without(task: FitTask, doubts: Sequence[PickIssue]) -> FitTask:
    """The task without the rejected picks."""
    return task.without({name for doubt in doubts if not doubt.followed for name in doubt.names})


def ended(task: FitTask, last: FitIterate) -> FitTask:
    """The task as its fit ended: without the rejected picks, with the relief observations."""
    return replace(without(task, last.not_followed), relief=last.relief, hanging=last.hanging)


def _parts(recipe: Recipe) -> tuple[Recipe | None, Recipe | None]:
    """The stages that doubt picks, and those after them."""
    robust = [index for index, stage in enumerate(recipe.stages) if stage.doubts_picks]
    cut = robust[-1] + 1 if robust else 0
    parts = recipe.stages[:cut], recipe.stages[cut:]
    first, rest = (recipe.model_copy(update={"stages": part}) if part else None for part in parts)
    return first, rest
