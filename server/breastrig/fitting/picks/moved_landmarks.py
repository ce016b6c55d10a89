"""A finished fit that follows landmarks while a person drags them.

It goes on from where the model stands, with the observations of the recipe's last stage as they are at its end.  For
picks that moved a little, a few iterations end where a fit from the beginning would end if it went on for long: 0.00 to
0.20 mm apart in the mean, and 0.1 to 0.25 mm from where such a fit stops (example patient, picks moved by 10 to
17 mm).  Picks are followed as they are; whether one is strange is judged by the fit that is made when the drag has
ended.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.recipe import Recipe, Stage
from breastrig.fitting.task import FitIterate, FitTask

ITERATIONS = 4  # a drag sends many positions; what one of them leaves open, the next one closes
STILL = 1e-9  # m, of the mean distance; where a fit may call itself still it lies up to 0.1 mm before its end
HOLDS = 0.8  # of the most vertices that met the scan; a drag over the whole breast leaves 0.98


class FittedScan:
    """One scan with its model, which moves with the picks.  `task` starts where its fit has ended."""

    def __init__(self, task: FitTask) -> None:
        self._fitted = self._task = replace(task, recipe=settled(task.recipe))
        self._coverage = 0.0

    @property
    def task(self) -> FitTask:
        """The task with the landmarks and the pose of the last move."""
        return self._task

    def moved(self, landmarks: Mapping[str, Array]) -> FitIterate:
        """The model for these picks, {name: (3,) m, in the scan's frame}; its status says whether there is one.

        Where picks have torn it off the scan the next move starts from the fit again.
        """
        before, moved = self._task.given, self._task.with_picks(landmarks).given
        stay = {name for name in moved.keys() & before.keys() if np.array_equal(moved[name].place, before[name].place)}
        asked = replace(self._task, given={**moved, **{name: before[name] for name in stay}})
        *_, last = fit_iterates(asked)
        self._coverage = max(self._coverage, last.coverage)
        holds = last.is_finite and last.coverage > HOLDS * self._coverage
        self._task = replace(asked, start=last.parameters) if holds else self._fitted
        return last


def settled(recipe: Recipe, iterations: int = ITERATIONS) -> Recipe:
    """The last stage alone, at its last temperature."""
    last = recipe.stages[-1]
    still = (last.temperature[1], last.temperature[1])
    stage: Stage = last.model_copy(update={"temperature": still, "iterations": iterations, "tighten": 1})
    stop = recipe.stop.model_copy(update={"distance_change_m": STILL})
    return recipe.model_copy(update={"stages": (stage,), "stop": stop})
