"""Observations of landmarks from the relief of the skin (relief/observe.py), made once a fit, each with a covariance.

Picks and colour observations of the same landmark replace them.  The fold under a hanging breast is not observed: the
furrow in the camera's view is up to 50 mm below it (body/hanging.py).
"""

from collections.abc import Mapping

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE, STANDING
from breastrig.energies.landmark_observations import LandmarkObservations
from breastrig.fitting.body.hanging import body_axes, hanging_shifts, hangs_by, outwards
from breastrig.fitting.recipe import Stage
from breastrig.fitting.task import FitTask
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import unit_vectors
from breastrig.least_squares.problem import ResidualTerm
from breastrig.relief.limits import relief as relief_limits
from breastrig.relief.observe import NOT_SHOWN, Expected, ReliefObservation, relief_observations
from breastrig.relief.prone import REASON, seen_from
from breastrig.relief.shoulder import lying_tip, shoulder_tip
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.rig.state import BodyState

NOTCH = "suprasternal_notch"
TIPS = {"acromion_L": "upper_arm_L", "acromion_R": "upper_arm_R"}
ARM = 0.9  # share of a vertex that moves with the upper arm; with half of it the shoulder itself is in front


def observe_relief(task: FitTask, state: BodyState) -> dict[str, ReliefObservation]:
    """What the scan shows of the landmarks that nobody picked, expected where the model has them now."""
    rig = task.rig
    points = rig.landmark_points()
    places = points.positions(state.vertices, rig.faces)
    if task.stance == PRONE:
        return _prone(task, state)
    if len(places) < 3 or not np.isfinite(places).all():
        return {}
    covered = np.any(hanging_shifts(state, task, rig.landmark_names) != 0.0, axis=1)
    normals = unit_vectors(points.positions(state.normals, rig.faces))
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation
    expected = {
        name: Expected(places[k], normals[k])
        for k, name in enumerate(rig.landmark_names)
        if name not in task.landmarks and not covered[k]
    }
    tips = _tips if task.stance == STANDING else _lying_tips
    return relief_observations(task.target, expected, axes) | tips(task, state, expected, axes)


def _prone(task: FitTask, state: BodyState) -> dict[str, ReliefObservation]:
    """What hanging breasts show."""
    axes = body_axes(task.rig, state.vertices)
    view = seen_from(task.target.vertices, task.target.faces, axes)
    if view is None:
        return {}
    seen = {}
    for name, place in view.places.items():
        if name in task.rig.landmark_names and name not in task.landmarks:
            own = axes * outwards(name)
            covariance = (own * np.array(view.errors[name]) ** 2) @ own.T
            seen[name] = ReliefObservation(place, covariance, REASON, all_round=name.startswith(("nipple", "xiphoid")))
    return seen


def _lying_tips(
    task: FitTask, state: BodyState, expected: Mapping[str, Expected], axes: Array
) -> dict[str, ReliefObservation]:
    """The tips of the shoulders of a supine body, and the middles of the collar bones half way to them."""
    rules, seen, rig = relief_limits().lying_shoulder, {}, task.rig
    if not task.from_colour.issuperset(task.landmarks) or NOTCH not in expected:
        return {}
    skin = ClosestPointSearch(state.vertices, rig.faces)
    for name in expected.keys() & TIPS.keys():
        arm = TIPS[name]
        if arm not in rig.bone_names:
            continue
        own = axes * outwards(name)  # (3, 3) columns: outwards, up, front
        of_arm = state.vertices[rig.skin_weights[:, rig.bone_names.index(arm)] > ARM]
        if not len(of_arm):
            continue
        notch, front = expected[NOTCH].place, of_arm[(of_arm @ own[:, 2]).argmax()]
        tip = lying_tip(notch @ own, expected[name].place @ own, front @ own, rules)
        if tip is None or not _shown(task, np.stack([notch, front]), rules.shown):
            continue
        places = {name: (tip, rules.errors)}
        middle = "midclavicle" + name[-2:]
        if middle in expected:
            beside = expected[middle].place @ own
            beside[0] = (1.0 - rules.midclavicle) * (notch @ own)[0] + rules.midclavicle * tip[0]
            places[middle] = beside, (rules.midclavicle_error, NOT_SHOWN, NOT_SHOWN)
        for each, (place, errors) in places.items():
            near = skin.query((own @ place)[None]).points[0]
            covariance = (own * np.array(errors) ** 2) @ own.T
            seen[each] = ReliefObservation(near, covariance, rules.reason, each == name, rules.slack)
    return seen


def _tips(
    task: FitTask, state: BodyState, expected: Mapping[str, Expected], axes: Array
) -> dict[str, ReliefObservation]:
    """The tips of the shoulders of a standing body; none where a person has picked any landmark."""
    if not task.from_colour.issuperset(task.landmarks):
        return {}
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
            hangs = hangs_by(state, task.recipe, name) > 0.0
            errors = np.array(rules.errors) * (rules.where_hanging if hangs else 1.0)
            seen[name] = ReliefObservation(places[0], (own * errors**2) @ own.T, rules.reason, all_round=True)
    return seen


def _shown(task: FitTask, places: Array, near: float) -> bool:
    """Whether the scan has a vertex within `near` m of each of the (N, 3) m places."""
    return bool(np.isfinite(task.target.vertex_tree.query(places, distance_upper_bound=near)[0]).all())


def relief_terms(rig: Rig, relief: Mapping[str, ReliefObservation], stage: Stage) -> list[ResidualTerm[BodyState]]:
    """Their residual term; none without observations."""
    if not relief:
        return []
    places, covariances = zip(*((each.place, each.slack**2 * each.covariance) for each in relief.values()), strict=True)
    points = rig.landmark_points(tuple(relief))
    return [LandmarkObservations(rig, points, np.array(places), (stage.relief or 1.0) ** 2 * np.array(covariances))]
