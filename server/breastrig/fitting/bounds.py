"""Which unknowns a step may move, and how far."""

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.recipe import Stage
from breastrig.fitting.task import FitTask
from breastrig.least_squares.newton import Bounds
from breastrig.rig.parameters import BONE_DOFS, RigParameters


def step_bounds(task: FitTask, x: RigParameters) -> Bounds:
    """Room left for the scales and the shape weights."""
    rig, constraint = task.rig, task.recipe.shapes.constraint
    lower, upper = np.full(x.dof, -np.inf), np.full(x.dof, np.inf)
    bones = len(rig.bones)
    for side, values in ((lower, [b.scale_min for b in rig.bones]), (upper, [b.scale_max for b in rig.bones])):
        side[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = np.array(values) - x.scales
    first = BONE_DOFS * bones
    if constraint == "box":
        lower[first:] = np.array([shape.min for shape in rig.shapes]) - x.weights
        upper[first:] = np.array([shape.max for shape in rig.shapes]) - x.weights
    equalities = None
    if constraint == "simplex":  # weights and the template's remaining share are >= 0 and sum to one
        lower[first:] = -x.weights
        if x.weights.sum() >= 1.0 - 1e-9:
            equalities = np.zeros((1, x.dof))
            equalities[0, first:] = 1.0
    return Bounds(np.minimum(lower, 0.0), np.maximum(upper, 0.0), equalities)


def free_unknowns(task: FitTask, stage: Stage, dof: int) -> Booleans:
    """(P,) what the stage lets move."""
    free = np.ones(dof, dtype=np.bool_)
    bones = len(task.rig.bones)
    free[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = stage.free_scales
    free[BONE_DOFS * bones :] = [shape.kind in stage.free_shapes for shape in task.rig.shapes]
    return free


def onto_simplex(weights: Array) -> Array:
    """(S,) the nearest weights in {α >= 0, Σα <= 1} (Duchi et al., 2008)."""
    weights = np.maximum(weights, 0.0)
    if weights.sum() > 1.0:
        ordered = np.sort(weights)[::-1]
        excess = (np.cumsum(ordered) - 1.0) / np.arange(1, len(ordered) + 1)
        weights = np.maximum(weights - excess[np.flatnonzero(ordered > excess)[-1]], 0.0)
    return weights
