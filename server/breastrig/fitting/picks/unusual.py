"""Picks that were followed although all else expects them elsewhere: named, so that a person looks once more."""

from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.picks.refit_without import from_expected, from_observation, on_smooth_skin, refit_without
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.task import Doubt

SUSPECTED = 0.8  # of its limit; to first order a wrong pick on smooth skin looks nearer than it is (refit_without.py)


def unusual(posterior: Posterior) -> tuple[Doubt, ...]:
    """One doubt each, the strangest first; certain picks are not asked about again.

    A wrong pick pushes its neighbours, so one after the other is left out: each time, of those that are SUSPECTED to
    first order, the one without which the others agree best.  It is named if it is beyond its limit also to
    the fit that goes on without it, and the others are judged by that fit.  Navels on smooth skin come first.
    """
    if posterior.picks is None:
        return ()
    task = posterior.task
    posterior = posterior.of_picks_alone
    found: dict[str, float] = {}  # name -> m
    for name in on_smooth_skin(posterior):
        without = refit_without(posterior, (name,))
        seen = from_observation(without, task.given[name])
        if seen is not None and seen[1] > _limit(task.recipe, name):
            found[name], posterior = seen[0], without
    cleared: set[str] = set()
    while (suspect := _most_suspicious(posterior, {*found, *cleared})) is not None:
        without = refit_without(posterior, (suspect,))
        gap, deviation = from_expected(without, task.given[suspect])
        if deviation > _limit(task.recipe, suspect):
            found[suspect], posterior = gap, without
        else:
            cleared.add(suspect)
    return tuple(
        Doubt(
            (name,),
            f"{name} is {1e3 * gap:.0f} mm from where the scan and the other landmarks expect it; "
            "it was followed. Is it right?",
            followed=True,
        )
        for name, gap in found.items()
    )


def _most_suspicious(posterior: Posterior, judged: set[str]) -> str | None:
    """Of the suspected picks that are not yet judged the one without which the others agree best."""
    if posterior.picks is None:
        return None
    picks, task = LeaveOneOut(posterior), posterior.task
    deviations = picks.deviations()
    suspects = [
        name
        for name in picks.names
        if name not in judged | task.certain and deviations[name] > SUSPECTED * _limit(task.recipe, name)
    ]
    return min(suspects, key=lambda name: _disagreement(picks, task.recipe, name), default=None)


def _limit(recipe: Recipe, name: str) -> float:
    return recipe.landmark_errors(name).unusual or recipe.outliers.unusual


def _disagreement(picks: LeaveOneOut, recipe: Recipe, without: str) -> float:
    deviations = picks.deviations(without=(without,))
    return sum((deviations[name] / _limit(recipe, name)) ** 2 for name in picks.names if name != without)
