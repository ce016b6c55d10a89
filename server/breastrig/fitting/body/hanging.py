"""How ptotic fitted breasts are, and what follows for landmarks on and beside them (docs/decisions/0003).

The rig's shape of ptosis moves nipple and fold down as one artist's breasts do; real breasts differ, most of them over
a fold that stays nearly where it was and is covered.  So the expected place of a landmark moves with its weight,
and its standard deviation grows with it, most along the body.
"""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import OUTWARDS, SIDES, split_side
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.task import FitTask
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.rig.state import BodyState


def outwards(name: str) -> Array:
    """(3,) signs that make a left landmark's shift, in the body's axes, that of this one."""
    return np.array([OUTWARDS.get(split_side(name)[1], 1.0), 1.0, 1.0])


def hanging_weight(state: BodyState, recipe: Recipe, landmark: str) -> float:
    """Weight of the shape on the landmark's side, of both in the middle; 0 where it is lifted, or nothing is known."""
    if recipe.hanging is None:
        return 0.0
    names, side = state.rig.shape_names, split_side(landmark)[1]
    shapes = [f"{recipe.hanging.shape}_{each}" for each in (side or SIDES)]
    if not {*shapes} <= {*names}:
        return 0.0
    return max(float(np.mean([state.x.weights[names.index(shape)] for shape in shapes])), 0.0)


def hangs_by(state: BodyState, recipe: Recipe, landmark: str) -> float:
    """The weight where it is that of breasts that hang, as hanging_shapes has it; 0 where it is less."""
    weight = hanging_weight(state, recipe, landmark)
    return weight if recipe.hanging is not None and weight > recipe.hanging.weight - recipe.hanging.sigma else 0.0


def hanging_shifts(state: BodyState, task: FitTask, names: Sequence[str]) -> Array:
    """(L, 3) m from the model's landmarks to where they are expected: nothing for picks, and where no breast hangs.

    Without any picks the weight alone does not tell: of women whose breasts do not hang one side in 25 has as much.
    Only sides that were seen to hang count then (hanging_start.py).
    """
    moved = np.zeros((len(names), 3))
    for shift, name in zip(moved, names, strict=True):
        known = task.landmarks or any(shape.endswith(name[-2:]) for shape in task.hanging)
        if known and name not in task.landmarks and hangs_by(state, task.recipe, name):
            shift += hanging_misfit(state, task.recipe, name)[0]
    return moved


def hanging_misfit(state: BodyState, recipe: Recipe, landmark: str) -> tuple[Array, Array]:
    """(3,) m from the model's landmark to where it is expected, and (3, 3) m², covariance around there, of hanging."""
    known, weight = recipe.landmark_errors(landmark), hanging_weight(state, recipe, landmark)
    if not weight:
        return np.zeros(3), np.zeros((3, 3))
    axes = body_axes(state.rig, state.vertices)
    spread = axes * (weight * np.array(known.hanging))
    return axes @ (weight * outwards(landmark) * np.array(known.hanging_shift)), spread @ spread.T


def body_axes(rig: Rig, vertices: Array) -> Array:
    """(3, 3) columns: the body's left, up and front in the frame of its (V, 3) m vertices."""
    points = rig.landmark_points()
    return umeyama(points.positions(rig.template, rig.faces), points.positions(vertices, rig.faces)).rotation
