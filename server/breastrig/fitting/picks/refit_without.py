"""A suspicious pick judged by the fit that goes on for a few iterations without it (docs/decisions/0011).

Leave-one-out residuals (leave_one_out.py) are first order, which is too little where the pick has bent the fit far.  A
navel's model follows any pick on a smooth belly: there the question is whether the skin under the pick is smooth and
shows a dent elsewhere.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.hanging import body_axes, hanging_misfit
from breastrig.fitting.fit import fit_iterates
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


def from_expected(without: Posterior, pick: LandmarkObservation) -> tuple[float, float]:
    """m from where a fit without the pick expects it to the pick, and in standard deviations."""
    state, recipe = without.state, without.task.recipe
    shift, hanging = hanging_misfit(state, recipe, pick.name)
    misfit = recipe.landmark_errors(pick.name).misfit ** 2 * np.eye(3)
    covariance = without.landmark_covariances((pick.name,))[0] + hanging + misfit + pick.covariance
    return _measured(pick.place - expected(without, pick.name).place - shift, covariance)


def from_observation(without: Posterior, pick: LandmarkObservation) -> tuple[float, float] | None:
    """As from_expected, from the landmark's concavity that the skin shows to that fit; None where it shows none."""
    seen = without.relief.get(pick.name)
    return None if seen is None else _measured(pick.place - seen.place, seen.covariance + pick.covariance)


def _measured(gap: Array, covariance: Array) -> tuple[float, float]:
    return float(np.linalg.norm(gap)), float(np.sqrt(gap @ np.linalg.solve(covariance, gap)))


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
