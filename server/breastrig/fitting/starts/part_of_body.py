"""Where the rest pose starts on a scan of a part of a body: a few heights, each fitted for two stages, the best kept.

Laid on a part (rigid_search.py) the rest pose covers what there is, and would shrink into it; such a minimum has more
energy than the right one.  Evidence: docs/decisions/0009.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.task import FitTask
from breastrig.rig.model import Rig
from breastrig.rig.similarity import Similarity, similar_parameters

SHIFTS = (0.0, 0.03, 0.06, -0.03, -0.06)  # m along the body; half of the basin, and of what a place on a part is off


@cache
def judge() -> Recipe:
    """The settings that every start is judged by, whatever those of the fit: the place belongs to the scan."""
    recipe = load_recipe("default")
    return recipe.model_copy(update={"stages": recipe.stages[:2]})


def best_height(rig: Rig, target: ScanTarget, place: Similarity) -> Similarity:
    """The place, moved along the body to where a fit ends with the least energy."""
    stance = "standing" if target.table is None else "supine"

    def at(shift: float) -> Similarity:
        return replace(place, translation=place.translation + shift * place.rotation[:, 1])

    def energy(start: Similarity) -> float:
        *_, last = fit_iterates(FitTask(rig, target, similar_parameters(rig, start), judge(), {}, stance))
        return last.energy if last.is_finite else np.inf

    return min(map(at, SHIFTS), key=energy)
