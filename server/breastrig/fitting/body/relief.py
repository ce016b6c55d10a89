"""Observations of landmarks from the relief of the skin (relief/observe.py), made once a fit, each with a covariance.

Picks and colour observations of the same landmark replace them.  The fold under a hanging breast is not observed: the
furrow in the camera's view is up to 50 mm below it (body/hanging.py).
"""

import numpy as np

from breastrig.core.stances import PRONE, split_side
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.hanging import body_axes, covered_landmarks, outwards
from breastrig.fitting.task import FitTask
from breastrig.geometry.normals import unit_vectors
from breastrig.relief.observe import Expected, relief_observations
from breastrig.relief.prone import ERRORS, REASON, seen_from
from breastrig.rig.similarity import umeyama
from breastrig.rig.state import BodyState


def observe_relief(task: FitTask, state: BodyState) -> dict[str, LandmarkObservation]:
    """What the scan shows of the landmarks that nobody picked, expected where the model has them now."""
    rig = task.rig
    points = rig.landmark_points()
    places = points.positions(state.vertices, rig.faces)
    if task.stance == PRONE:
        return _prone(task, state)
    if len(places) < 3 or not np.isfinite(places).all():
        return {}
    covered = covered_landmarks(state, task)
    normals = unit_vectors(points.positions(state.normals, rig.faces))
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation
    expected = {
        name: Expected(places[k], normals[k])
        for k, name in enumerate(rig.landmark_names)
        if name not in task.landmarks and name not in covered
    }
    return relief_observations(task.target, expected, axes)


def _prone(task: FitTask, state: BodyState) -> dict[str, LandmarkObservation]:
    """What hanging breasts show."""
    axes = body_axes(task.rig, state.vertices)
    places = seen_from(task.target.vertices, task.target.faces, axes) or {}
    seen = {}
    for name, place in places.items():
        if name in task.rig.landmark_names and name not in task.landmarks:
            own = axes * outwards(name)
            covariance = (own * np.array(ERRORS[split_side(name)[0]]) ** 2) @ own.T
            seen[name] = LandmarkObservation(name, place, covariance, "form", reason=REASON)
    return seen
