"""Picks that were followed although all else expects them elsewhere: named, so that a person looks once more."""

from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.picks.refit_without import from_observation, on_smooth_skin, refit_without
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.task import PickIssue


def unusual(posterior: Posterior) -> tuple[PickIssue, ...]:
    """One doubt each, the strangest first; certain picks are not asked about again.

    A wrong pick pushes its neighbours, so one after the other is named: each time, of those beyond the limit the one
    without which the others agree best; these are judged by the fit that goes on without it.  Navels on smooth skin
    come first.
    """
    if posterior.picks is None:
        return ()
    task, limit = posterior.task, posterior.task.recipe.outliers.unusual
    posterior = posterior.of_picks_alone
    found: dict[str, float] = {}  # name -> m
    for name in on_smooth_skin(posterior):
        without = refit_without(posterior, (name,))
        seen = from_observation(without, task.given[name])
        if seen is not None and seen[1] > limit:
            found[name], posterior = seen[0], without
    while posterior.picks is not None:
        picks = LeaveOneOut(posterior)
        beyond = [name for name, each in picks.deviations().items() if each > limit and name not in task.certain]
        if not beyond:
            break
        name = min(beyond, key=lambda each: _disagreement(picks, each))
        found[name], posterior = picks.gaps()[name], refit_without(posterior, (name,))
        if name in posterior.task.given:  # the fit without it broke down
            break
    return tuple(
        PickIssue(
            (name,),
            f"{name} is {1e3 * gap:.0f} mm from where the scan and the other landmarks expect it; "
            "it was followed. Is it right?",
            followed=True,
        )
        for name, gap in found.items()
    )


def _disagreement(picks: LeaveOneOut, without: str) -> float:
    deviations = picks.deviations(without=(without,))
    return sum(deviations[name] ** 2 for name in picks.names if name != without)
