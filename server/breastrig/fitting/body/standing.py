"""Landmarks of a standing woman beside the fitted model's, in fits without picks (docs/decisions/0012).

A model that slides along a fold has its landmark nearer to the sternum than bodies have theirs, in every woman alike:
the observed fold (relief/observe.py) says how high it is, not where along it.
"""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import STANDING
from breastrig.fitting.body.hanging import OUTWARDS_ON_THE_RIGHT, body_axes
from breastrig.fitting.task import FitTask


def standing_shifts(vertices: Array, task: FitTask, names: Sequence[str]) -> Array:
    """(L, 3) m from the landmarks of a model with (V, 3) m `vertices` to where they are expected; nothing for picks."""
    moved = np.zeros((len(names), 3))
    if task.stance != STANDING:
        return moved
    axes = body_axes(task.rig, vertices)
    for shift, name in zip(moved, names, strict=True):
        if name not in task.landmarks:
            mirror = OUTWARDS_ON_THE_RIGHT if name.endswith("_R") else np.ones(3)
            shift += axes @ (mirror * np.array(task.recipe.landmark_errors(name).standing_shift))
    return moved
