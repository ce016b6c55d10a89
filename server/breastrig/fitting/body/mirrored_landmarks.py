"""Landmarks without a pick, expected from their picked partners on the other side (docs/decisions/0006).

Mirrored is how far the partner is from the model's place *without the picks*, in the body's axes.  To first order the
model without them is δ = H₀⁻¹ g away: H₀ are the normal equations without the picks' term, g is that term's gradient,
which balances all others where a fit has settled.  Partners on skin that the scan does not show are less sure.
"""

import math
from collections.abc import Callable

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import split_side
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.fitting.task import FitTask
from breastrig.least_squares.newton import System
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.similarity import umeyama
from breastrig.rig.state import BodyState

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
    factor = cholesky(others.hessian + np.diag(DAMPING * scaling))
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
