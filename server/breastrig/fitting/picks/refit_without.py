"""The fit that goes on for a few iterations without a pick, and what the skin shows to it (docs/decisions/0011).

Other picks are judged by it: leave-one-out residuals (leave_one_out.py) are first order, which is too little for the
neighbours of a pick that has bent the fit far.  A navel's model follows any pick on a smooth belly: there the question
is whether the skin under the pick is smooth and shows a dent elsewhere.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.picks.leave_one_out import along_skin
from breastrig.fitting.picks.moved_landmarks import settled
from breastrig.fitting.posterior import Posterior
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
