"""A fit that believes the person who picked landmarks, and says what is strange.

A pick on the skin is evidence of a few millimetres; where the model's proportions put a landmark is a guess.  So all
picks are followed in the end, whatever their distance.  In between, while the landmark term still lets distant picks
go, those that are explained by a mistake with a name are taken out (mistakes.py); at the end those that all else
contradicts are named (unusual.py).  Both decide in standard deviations of what is expected, never in millimetres.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from breastrig.fitting.doubt import Doubt
from breastrig.fitting.orientation import MIN_LANDMARKS
from breastrig.fitting.picks.mistakes import mistaken
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.starts.two_openings import opened_iterates
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status


def checked_iterates(task: FitTask) -> Iterator[FitIterate]:
    """As opened_iterates; iterates after a pick was let go name it in `not_followed`."""
    first, rest = _parts(task.recipe)
    if not task.landmarks or task.seen or first is None or rest is None:
        yield from opened_iterates(task)
        return
    for iterate in opened_iterates(replace(task, recipe=first)):
        if iterate.status is Status.RUNNING:
            yield iterate
    if iterate.status is Status.NOT_FINITE:
        yield iterate
        return
    most = min(int(task.recipe.outliers.most * len(task.landmarks)), len(task.landmarks) - MIN_LANDMARKS)
    doubts = mistaken(task, iterate.parameters, most)
    begun = iterate
    going_on = replace(without(task, doubts), start=begun.parameters, recipe=rest, hanging=begun.hanging)
    for iterate in opened_iterates(going_on):
        yield replace(
            iterate,
            iteration=begun.iteration + iterate.iteration,
            elapsed_s=begun.elapsed_s + iterate.elapsed_s,
            not_followed=doubts,
        )


def without(task: FitTask, doubts: Sequence[Doubt]) -> FitTask:
    """The task without the picks that were let go."""
    gone = {name for doubt in doubts if not doubt.followed for name in doubt.names}
    kept = {name: place for name, place in task.landmarks.items() if name not in gone}
    return replace(task, landmarks=kept, certain=task.certain & frozenset(kept))


def ended(task: FitTask, last: FitIterate) -> FitTask:
    """The task as its fit ended: without the picks that were let go, and with what was seen of the skin's form."""
    return replace(without(task, last.not_followed), relief=last.relief, hanging=last.hanging)


def agreeing_picks(task: FitTask, begun: Sequence[FitIterate] = ()) -> tuple[FitTask, tuple[Doubt, ...]]:
    """The task without the picks that are let go, and these: of a fit of its own, or of `begun`, all its iterates."""
    if not task.landmarks or task.seen:
        return task, ()
    *_, last = begun or checked_iterates(task)
    return without(task, last.not_followed), last.not_followed


def _parts(recipe: Recipe) -> tuple[Recipe | None, Recipe | None]:
    """The stages that let distant picks go, and those after them that follow all."""
    letting_go = [index for index, stage in enumerate(recipe.stages) if stage.landmark_kernel_scale is not None]
    cut = letting_go[-1] + 1 if letting_go else 0
    parts = recipe.stages[:cut], recipe.stages[cut:]
    first, rest = (recipe.model_copy(update={"stages": part}) if part else None for part in parts)
    return first, rest
