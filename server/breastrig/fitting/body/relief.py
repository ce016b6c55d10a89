"""Observations of landmarks from the relief of the skin (relief/observe.py), made once a fit, each with a covariance.

Picks and colour observations of the same landmark replace them.
"""

from collections.abc import Mapping

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE, STANDING, split_side
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.hanging import outwards, ptotic_shape_weight
from breastrig.fitting.task import FitTask
from breastrig.geometry.normals import unit_vectors
from breastrig.relief.limits import relief as relief_limits
from breastrig.relief.observe import Expected, relief_observations
from breastrig.relief.prone import ERRORS, REASON, seen_from
from breastrig.relief.shoulder import shoulder_tip
from breastrig.rig.similarity import body_axes, umeyama
from breastrig.rig.state import BodyState

TIPS = ("acromion_L", "acromion_R")


def observe_relief(task: FitTask, state: BodyState) -> dict[str, LandmarkObservation]:
    """Observations from the scan's relief of the landmarks that nobody picked, near the model's."""
    rig = task.rig
    points = rig.landmark_points()
    places = points.positions(state.vertices, rig.faces)
    if task.stance == PRONE:
        return _prone(task, state)
    if len(places) < 3 or not np.isfinite(places).all():
        return {}
    normals = unit_vectors(points.positions(state.normals, rig.faces))
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation
    expected = {
        name: Expected(places[k], normals[k]) for k, name in enumerate(rig.landmark_names) if name not in task.landmarks
    }
    tips = _tips(task, state, expected, axes) if task.stance == STANDING else {}
    return relief_observations(task.target, expected, axes) | tips


def _prone(task: FitTask, state: BodyState) -> dict[str, LandmarkObservation]:
    """Observations from hanging breasts."""
    axes = body_axes(task.rig, state.vertices)
    places = seen_from(task.target.vertices, task.target.faces, axes) or {}
    seen = {}
    for name, place in places.items():
        if name in task.rig.landmark_names and name not in task.landmarks:
            own = axes * outwards(name)
            covariance = (own * np.array(ERRORS[split_side(name)[0]]) ** 2) @ own.T
            seen[name] = LandmarkObservation(name, place, covariance, "form", reason=REASON)
    return seen


def _tips(
    task: FitTask, state: BodyState, expected: Mapping[str, Expected], axes: Array
) -> dict[str, LandmarkObservation]:
    """The tips of the shoulders of a standing body."""
    rules, seen = relief_limits().shoulder, {}
    for name, each in expected.items():
        if name not in TIPS:
            continue
        own = axes * outwards(name)  # (3, 3) columns: outwards, up, front
        tip = shoulder_tip(state.vertices @ own, task.rig.faces, each.place @ own, rules)
        if tip is None:
            continue
        places = np.stack([tip.place, tip.edge, tip.front]) @ own.T
        if _shown(task, places[1:], rules.shown):
            hangs = ptotic_shape_weight(state, task.recipe, name) > 0.0
            errors = np.array(rules.errors) * (rules.where_hanging if hangs else 1.0)
            seen[name] = LandmarkObservation(name, places[0], (own * errors**2) @ own.T, "form", reason=rules.reason)
    return seen


def _shown(task: FitTask, places: Array, near: float) -> bool:
    """Whether the scan has a vertex within `near` m of each of the (N, 3) m places."""
    return bool(np.isfinite(task.target.vertex_tree.query(places, distance_upper_bound=near)[0]).all())
