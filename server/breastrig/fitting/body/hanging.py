"""How ptotic fitted breasts are, by the weight of the rig's shape of ptosis (docs/decisions/0003)."""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import OUTWARDS, SIDES, split_side
from breastrig.fitting.recipe import Recipe
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


def body_axes(rig: Rig, vertices: Array) -> Array:
    """(3, 3) columns: the body's left, up and front in the frame of its (V, 3) m vertices."""
    points = rig.landmark_points()
    return umeyama(points.positions(rig.template, rig.faces), points.positions(vertices, rig.faces)).rotation
