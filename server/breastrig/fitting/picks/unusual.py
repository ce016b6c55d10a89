"""Picks that were followed although all else expects them elsewhere: named, so that a person looks once more.

Others are judged by a fit that goes on for a few iterations without the pick, and by what the skin shows to it
(docs/decisions/0011): leave-one-out residuals (posterior.py) are first order, which is too little for the neighbours of
a pick that has bent the fit far.  A navel's model follows any pick on a smooth belly: there the question is whether the
skin under the pick is smooth and shows a dent elsewhere.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.picks.moved_landmarks import settled
from breastrig.fitting.posterior import LeaveOneOut, Posterior, along_skin
from breastrig.fitting.task import PickIssue
from breastrig.geometry.normals import unit_vectors
from breastrig.relief.limits import relief
from breastrig.relief.observe import Expected, is_on_smooth_skin

ITERATIONS_WITHOUT = 2  # iterations; of 398 picks 50 mm off 393 are named, 388 after one, 393 after three
ITERATIONS_OBSERVED = 1  # with what the skin shows from there; the same after two and three


def refit_without(posterior: Posterior, names: Collection[str]) -> Posterior:
    """Where the fit ends without these picks; itself where it breaks down."""
    task, x = posterior.task, posterior.state.x
    task = task.without(names)
    for iterations, known in ((ITERATIONS_WITHOUT, task.relief or {}), (ITERATIONS_OBSERVED, None)):
        going_on = replace(task, start=x, recipe=settled(task.recipe, iterations), relief=known)
        *_, last = fit_iterates(going_on)
        if not last.is_finite:
            return posterior
        x = last.parameters
    return Posterior(replace(task, relief=last.relief), x, partners=False)


def from_observation(without: Posterior, pick: LandmarkObservation) -> tuple[float, float] | None:
    """m from the landmark's concavity that the skin shows to a fit without the pick to it, and in standard deviations.

    None where the skin shows none.
    """
    seen = without.relief.get(pick.name)
    if seen is None:
        return None
    gap, normal = pick.place - seen.place, expected(without, pick.name).outwards
    return float(np.linalg.norm(gap)), along_skin(gap, seen.covariance + pick.covariance, normal)


def on_smooth_skin(posterior: Posterior) -> tuple[str, ...]:
    """Picks that should lie in a concavity and lie where the scan shows none; certain ones are not among them."""
    task, rules = posterior.task, relief()
    open_to_doubt = [name for name in task.given if name not in task.certain]
    known = {
        name: concavity
        for name in open_to_doubt
        if (concavity := rules.concavity(name)) is not None and concavity.smooth
    }
    if not known:
        return ()
    axes = body_axes(task.rig, posterior.state.vertices)
    picked = {name: replace(expected(posterior, name), place=task.landmarks[name]) for name in known}
    return tuple(name for name, at in picked.items() if is_on_smooth_skin(task.target, known[name], at, axes))


def expected(posterior: Posterior, name: str) -> Expected:
    """Where the fitted model has the landmark."""
    state = posterior.state
    point = state.rig.landmark_points((name,))
    places, normals = (point.positions(each, state.rig.faces) for each in (state.vertices, state.normals))
    return Expected(places[0], unit_vectors(normals)[0])


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
