"""The degree of ptosis of fitted breasts: the weight of the rig's shape of ptosis (docs/decisions/0003)."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import SIDES, split_side
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import Hanging, Recipe, Stage
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState


def hanging_weight(state: BodyState, recipe: Recipe, landmark: str) -> float:
    """Weight of the shape on the landmark's side, of both in the middle; 0 where it is lifted, or unknown."""
    if recipe.hanging is None:
        return 0.0
    names, side = state.rig.shape_names, split_side(landmark)[1]
    shapes = [f"{recipe.hanging.shape}_{each}" for each in (side or SIDES)]
    if not {*shapes} <= {*names}:
        return 0.0
    return max(float(np.mean([state.x.weights[names.index(shape)] for shape in shapes])), 0.0)


def ptotic_shape_weight(state: BodyState, recipe: Recipe, landmark: str) -> float:
    """The weight where the breast counts as hanging, as in hanging_shapes; 0 where it is less."""
    weight = hanging_weight(state, recipe, landmark)
    return weight if recipe.hanging is not None and weight > recipe.hanging.weight - recipe.hanging.sigma else 0.0


TOP, BOTTOM, DEPTH = "mid_sternum", "umbilicus", "xiphoid"  # landmarks around the front of the trunk
BESIDE, BEHIND, OVER_NAVEL = 0.05, 0.04, 0.01  # m beyond the nipples to the sides, behind the xiphoid, above the navel
POINTS = 4000  # of the scan
DOWN = -0.2  # upward part of a normal: 12 degrees below level
TURNED, AWAY = 0.75, 0.006  # cosine between scan and model, m between scan and the model's tangent plane: not the same
PER_NORMAL = 0.03  # m that count as much as a normal turned by a radian, where a place's own skin is looked for


def opening_of(recipe: Recipe) -> tuple[Stage, ...]:
    """The stages that show whether a breast was flattened; none where the recipe does not test it."""
    names = [stage.name for stage in recipe.stages]
    if recipe.hanging is None or recipe.hanging.after not in names:
        return ()
    return recipe.stages[: names.index(recipe.hanging.after) + 1]


def unexplained_overhang(rig: Rig, target: ScanTarget, x: RigParameters) -> dict[str, float]:
    """Share, by side L and R, of downward-facing skin in front of the trunk that the model does not show.

    The model is posed by `x`. Empty for a rig without the landmarks that define the region.
    """
    wanted = (TOP, BOTTOM, DEPTH, *(f"nipple_{side}" for side in SIDES))
    if not {*wanted} <= {*rig.landmark_names}:
        return {}
    vertices, points = pose(rig, x), rig.landmark_points(wanted)
    places = points.positions(vertices, rig.faces)
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation  # columns: left, up, front
    top, bottom, depth, left, right = places @ axes
    middle, half = 0.5 * (top[0] + bottom[0]), 0.5 * abs(left[0] - right[0]) + BESIDE
    every = max(1, len(target.vertices) // POINTS)

    def in_front(local: Array) -> Integers:
        inside = (local[:, 1] > bottom[1] + OVER_NAVEL) & (local[:, 1] < top[1]) & (local[:, 2] > depth[2] - BEHIND)
        return np.flatnonzero(inside & (np.abs(local[:, 0] - middle) < half))

    skin = target.vertices[::every] @ axes
    front = in_front(skin)
    facing = target.normals[::every][front] @ axes
    down = facing[:, 1] < DOWN
    own = vertices @ axes
    near = in_front(own)
    if not down.any() or not len(near):
        return dict.fromkeys(SIDES, 0.0)
    outwards = vertex_normals(vertices, rig.faces)[near] @ axes
    seen, normals = skin[front[down]], facing[down]
    _, nearest = cKDTree(np.hstack([own[near], PER_NORMAL * outwards])).query(np.hstack([seen, PER_NORMAL * normals]))
    of_model = outwards[nearest]
    away = np.abs(np.einsum("mi,mi->m", seen - own[near][nearest], of_model))
    missed = (np.einsum("mi,mi->m", of_model, normals) < TURNED) | (away > AWAY)
    on_left = seen[:, 0] > middle
    return {side: float((missed & (on_left == (side == "L"))).sum()) / len(front) for side in SIDES}


def hanging_shapes(rig: Rig, x: RigParameters, recipe: Recipe) -> tuple[str, ...]:
    """The shapes of breasts that hang in a fit that has ended at `x`; empty where none does."""
    if recipe.hanging is None:
        return ()
    names = [f"{recipe.hanging.shape}_{side}" for side in SIDES]
    least = recipe.hanging.weight - recipe.hanging.sigma
    return tuple(n for n in names if n in rig.shape_names and x.weights[rig.shape_names.index(n)] > least)


def hanging_start(rig: Rig, start: RigParameters, settings: Hanging, unexplained: Mapping[str, float]) -> RigParameters:
    """The start, with hanging breasts where their skin is unexplained and the rig has the shape."""
    weights = start.weights.copy()
    for side, share in unexplained.items():
        name = f"{settings.shape}_{side}"
        if share > settings.least and name in rig.shape_names:
            weights[rig.shape_names.index(name)] = settings.weight
    return start if np.array_equal(weights, start.weights) else replace(start, weights=weights)
