"""Where landmarks that nobody picked are expected beside the fitted model's: all that is known of it, together."""

from collections.abc import Mapping, Sequence

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import STANDING
from breastrig.fitting.body.hanging import body_axes, hanging_shifts, outwards
from breastrig.fitting.task import FitTask
from breastrig.relief.limits import MidSternum, relief
from breastrig.rig.state import BodyState


def mid_sternum_step(notch: Array, xiphoid: Array, middle: Array, rules: MidSternum) -> Array:
    """(3,) m along the line between the ends, from where a model has the `middle` to where it is expected.

    notch, xiphoid, middle: (3,) m; nothing when the two ends are one place.
    """
    length = float((xiphoid - notch) @ (xiphoid - notch))
    if length == 0.0:
        return 0.0 * notch
    step: Array = rules.share * (rules.at - float((middle - notch) @ (xiphoid - notch)) / length) * (xiphoid - notch)
    return step


def standing_shifts(vertices: Array, task: FitTask, names: Sequence[str]) -> Array:
    """(L, 3) m from the landmarks of a model with (V, 3) m `vertices` to where they are expected; nothing for picks."""
    moved = np.zeros((len(names), 3))
    if task.stance != STANDING:
        return moved
    axes = body_axes(task.rig, vertices)
    for shift, name in zip(moved, names, strict=True):
        if name not in task.landmarks:
            shift += axes @ (outwards(name) * np.array(task.recipe.landmark_errors(name).standing_shift))
    return moved


NOTCH, XIPHOID, MIDDLE = "suprasternal_notch", "xiphoid", "mid_sternum"


def expected_shifts(places: Array, state: BodyState, task: FitTask, observed: Mapping[str, Array]) -> Array:
    """(L, 3) m from the (L, 3) m places of the model's landmarks; nothing for picks.

    `observed`: the (3,) m places by name of observed landmarks.
    """
    names = task.rig.landmark_names
    moved = hanging_shifts(state, task, names) + standing_shifts(state.vertices, task, names)
    now = {**dict(zip(names, places + moved, strict=True)), **observed}
    if now.keys() >= {NOTCH, XIPHOID, MIDDLE} and MIDDLE not in task.landmarks:
        step = mid_sternum_step(now[NOTCH], now[XIPHOID], now[MIDDLE], relief().mid_sternum)
        moved[names.index(MIDDLE)] += step
    return moved
