"""Where landmarks that nobody picked are expected beside the fitted model's: all that is known of it, together."""

from collections.abc import Mapping

from breastrig.core.arrays import Array
from breastrig.fitting.body.hanging import hanging_shifts
from breastrig.fitting.body.standing import standing_shifts
from breastrig.fitting.task import FitTask
from breastrig.relief.limits import relief
from breastrig.relief.mid_sternum import mid_sternum_step
from breastrig.rig.state import BodyState

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
