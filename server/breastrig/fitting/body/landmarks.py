"""Landmarks that nobody picked: where bodies have them, what the skin's relief shows of them, what their partners say.

Offsets of bodies' landmarks from the model's are data beside the rig: mean and standard deviation of each, in the
body's axes (outwards, up, front), around the landmark of a fit without a pick of it. Estimated on patients whose
landmarks are known (breastrig_studies/landmark_errors.py); docs/decisions/0028.

Observations from the relief of the skin (relief/observe.py) are made once a fit, each with a covariance.  Picks and
colour observations of the same landmark replace them.

Partners of picks on the other side are mirrored (docs/decisions/0006): how far the pick is from the model's place
*without the picks*, in the body's axes.  To first order the model without them is δ = H₀⁻¹ g away: H₀ are the normal
equations without the picks' term, g is that term's gradient, which balances all others where a fit has settled.
Partners on skin that the scan does not show are less sure.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import Field, FiniteFloat

from breastrig.core.arrays import Array
from breastrig.core.settings_file import NotNegative, SettingsPart
from breastrig.core.stances import PRONE, STANDING, split_side
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.fitting.body.hanging import ptotic_shape_weight
from breastrig.fitting.task import FitTask
from breastrig.geometry.normals import unit_vectors
from breastrig.least_squares.newton import System
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.relief.limits import relief
from breastrig.relief.limits import relief as relief_limits
from breastrig.relief.observe import Expected, relief_observations
from breastrig.relief.prone import ERRORS, REASON, seen_from
from breastrig.relief.shoulder import shoulder_tip
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig
from breastrig.rig.similarity import body_axes, outwards, umeyama
from breastrig.rig.state import BodyState

FILE, SCHEMA = "landmark_errors.json", "breastrig/landmark-errors@1"
UNKNOWN = 5.0  # mm on each axis, of rigs of which nothing is known


class LandmarkError(SettingsPart):
    """The offset of one landmark, left and right alike."""

    mean_mm: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)  # outwards, up, front
    deviation_mm: tuple[NotNegative, NotNegative, NotNegative] = (UNKNOWN, UNKNOWN, UNKNOWN)


class _File(SettingsPart):
    schema_: Literal["breastrig/landmark-errors@1"] = Field(alias="schema")
    stances: dict[str, dict[str, LandmarkError]]


@lru_cache(maxsize=8)
def landmark_errors(rig: Rig, stance: str) -> dict[str, LandmarkError]:
    """Offsets by the names of landmarks without their sides; a stance without its own has those of standing bodies."""
    known = known_part(rig, FILE, _File)
    return {} if known is None else known.stances.get(stance, known.stances.get(STANDING, {}))


@dataclass(frozen=True, eq=False)
class ExpectedGap:
    """The expected gap from the model's landmark to the body's, in the scan's frame."""

    mean: Array  # (3,) m
    covariance: Array  # (3, 3) m²


def expected_gaps(state: BodyState, stance: str) -> dict[str, ExpectedGap]:
    """The expected gaps of all landmarks of the rig."""
    known, found = landmark_errors(state.rig, stance), {}
    axes = body_axes(state.rig, state.vertices) if known else np.eye(3)
    for name in state.rig.landmark_names:
        error, own = known.get(split_side(name)[0], LandmarkError()), axes * outwards(name)
        spread = own * (1e-3 * np.array(error.deviation_mm))
        found[name] = ExpectedGap(own @ (1e-3 * np.array(error.mean_mm)), spread @ spread.T)
    return found


NOTCH, XIPHOID, MIDDLE = "suprasternal_notch", "xiphoid", "mid_sternum"


def middle_step(places: Mapping[str, Array]) -> Array:
    """(3,) m along the breastbone, from where a model has its middle to where it is expected between its ends.

    places: (3,) m by name, of these three; nothing when the two ends are one place.
    """
    rules, bone = relief().mid_sternum, places[XIPHOID] - places[NOTCH]
    length = float(bone @ bone)
    at = float((places[MIDDLE] - places[NOTCH]) @ bone) / length if length > 0.0 else rules.at
    return np.asarray(rules.share * (rules.at - at) * bone)


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


DAMPING = 1e-3  # of the unknowns' natural sizes: directions that nothing but the picks holds stay
SHOWN_DISTANCE = 0.015  # m: a place with scan this near is shown
UNSHOWN_ERROR = (
    0.010  # m on each axis more, of a place that is not; of none, 0.02, 0.01 and 0 the best on development bodies
)


def mirrored_landmarks(
    task: FitTask, state: BodyState, picks: Landmarks, others: Callable[[], System], scaling: Array
) -> tuple[LandmarkObservation, ...]:
    """Observations of the picks' partners that nobody picked, where the recipe has the similarity of the two sides.

    `others` gives the quadratic model of all terms but the picks' at `state`; scaling: see step_scaling.
    """
    rig = task.rig
    partners = {landmark.name: landmark.mirror for landmark in rig.landmarks}
    wanted = {
        partners[name]: (name, alike)
        for name in task.landmarks
        if partners[name] not in task.landmarks and (alike := task.recipe.partners.get(split_side(name)[0])) is not None
    }
    if not wanted:
        return ()
    points = rig.landmark_points()
    places = points.positions(state.vertices, rig.faces)
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation
    places = places + _without_picks(state, picks, others(), scaling)
    index = {name: k for k, name in enumerate(rig.landmark_names)}
    over = axes @ np.diag([-1.0, 1.0, 1.0]) @ axes.T
    mirrored = []
    for name, (picked, alike) in wanted.items():
        place = places[index[name]] + over @ (task.landmarks[picked] - places[index[picked]])
        shown = np.isfinite(task.target.vertex_tree.query(place, distance_upper_bound=SHOWN_DISTANCE)[0])
        error = math.hypot(alike, task.beyond_click(picked), 0.0 if shown else UNSHOWN_ERROR)
        mirrored.append(LandmarkObservation(name, place, error**2 * np.eye(3), "partner"))
    return tuple(mirrored)


def _without_picks(state: BodyState, picks: Landmarks, others: System, scaling: Array) -> Array:
    """(L, 3) m by which the model's landmarks move, to first order, when the picks are left out."""
    factor = cholesky(others.hessian + np.diag(DAMPING * scaling[: state.dof]))
    pull = picks.linearise(state)
    step = solve_lower(factor, solve_lower(factor, pull.residual @ pull.jacobian), transposed=True)
    rig = state.rig
    points = rig.landmark_points()
    corners = rig.faces[points.faces].ravel()
    moves = np.zeros((len(points.faces), 3))
    for axis in range(3):
        directions = (points.barycentric[:, :, None] * np.eye(3)[axis]).reshape(-1, 3)
        rows = state.posed.rows(corners, directions)
        moves[:, axis] = (rows[0::3] + rows[1::3] + rows[2::3]) @ step
    return moves
