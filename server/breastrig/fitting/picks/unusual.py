"""Picks that were followed although all else expects them elsewhere: named, so that a person looks once more."""

from breastrig.fitting.doubt import Doubt
from breastrig.fitting.picks.beside_hollow import beside_hollows
from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe


def unusual(posterior: Posterior) -> tuple[Doubt, ...]:
    """One doubt each, the strangest first; certain picks are not asked about again.

    Those whose hollow the scan shows elsewhere are found first (beside_hollow.py).  A wrong pick pushes its neighbours,
    so one after the other is taken out of the comparison: each time, of those beyond their limit, the one without which
    the others agree best.
    """
    task = posterior.task
    if posterior.picks is None:
        return ()
    picks, recipe = LeaveOneOut(posterior), task.recipe
    beside = {name: gap for name, (gap, away) in beside_hollows(posterior).items() if away > _limit(recipe, name)}
    found = [*beside]
    while True:
        deviations = picks.deviations(without=found)
        open_to_doubt = [name for name in picks.names if name not in found and name not in task.certain]
        suspects = [name for name in open_to_doubt if deviations[name] > _limit(recipe, name)]
        if not suspects:
            break
        found.append(min(suspects, key=lambda name: _disagreement(picks, recipe, (*found, name))))
    gaps = picks.gaps(without=found) | beside
    return tuple(
        Doubt(
            (name,),
            f"{name} is {1e3 * gaps[name]:.0f} mm from where the scan and the other landmarks expect it; "
            "it was followed. Is it right?",
            followed=True,
        )
        for name in found
    )


def _limit(recipe: Recipe, name: str) -> float:
    return recipe.landmark_errors(name).unusual or recipe.outliers.unusual


def _disagreement(picks: LeaveOneOut, recipe: Recipe, without: tuple[str, ...]) -> float:
    deviations = picks.deviations(without=without)
    return sum((deviations[name] / _limit(recipe, name)) ** 2 for name in picks.names if name not in without)
