"""Which unknowns a step may move, and how far."""

from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.recipe import Stage
from breastrig.fitting.task import FitTask
from breastrig.least_squares.quadratic_program import Bounds
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
    rows = limits = None
    if constraint == "simplex":  # weights and the template's remaining share are >= 0 and sum to one
        lower[first:] = -x.weights
        rows, limits = np.zeros((1, x.dof)), np.array([max(1.0 - x.weights.sum(), 0.0)])
        rows[0, first:] = 1.0
    return Bounds(np.minimum(lower, 0.0), np.maximum(upper, 0.0), rows, limits)


def free_unknowns(task: FitTask, stage: Stage, dof: int) -> Booleans:
    """(P,) what the stage lets move."""
    free = np.ones(dof, dtype=np.bool_)
    bones = len(task.rig.bones)
    free[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = stage.free_scales
    free[BONE_DOFS * bones :] = [shape.kind in stage.free_shapes for shape in task.rig.shapes]
    return free


def allowed_start(task: FitTask) -> RigParameters:
    """The task's start with its shape weights moved to where the recipe allows them; steps then keep them there."""
    x, constraint = task.start, task.recipe.shapes.constraint
    if constraint == "box":
        ranges = np.array([[shape.min, shape.max] for shape in task.rig.shapes])
        return replace(x, weights=np.clip(x.weights, ranges[:, 0], ranges[:, 1]))
    return replace(x, weights=onto_simplex(x.weights)) if constraint == "simplex" else x


def onto_simplex(weights: Array) -> Array:
    """(S,) the nearest weights in {α >= 0, Σα <= 1} (Duchi et al., 2008)."""
    weights = np.maximum(weights, 0.0)
    if weights.sum() > 1.0:
        ordered = np.sort(weights)[::-1]
        excess = (np.cumsum(ordered) - 1.0) / np.arange(1, len(ordered) + 1)
        weights = np.maximum(weights - excess[np.flatnonzero(ordered > excess)[-1]], 0.0)
    return weights
