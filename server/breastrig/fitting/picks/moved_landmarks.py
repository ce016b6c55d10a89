"""A finished fit that follows landmarks while a person drags them.

It goes on from where the model stands, with the observations of the recipe's last stage as they are at its end.  For
picks that moved a little, a few iterations end where a fit from the beginning would end if it went on for long: 0.00 to
0.08 mm apart in the mean, and 0.04 to 0.15 mm from where such a fit stops (example patient, picks moved by 10 to
17 mm).  Picks are followed as they are; whether one is strange is judged by the fit that is made when the drag has
ended.
"""

from collections.abc import Mapping
from dataclasses import replace

from breastrig.core.arrays import Array
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.recipe import Recipe, Stage
from breastrig.fitting.task import FitIterate, FitTask

ITERATIONS = 4  # a drag sends many positions; what one of them leaves open, the next one closes
STILL = 1e-9  # m, of the mean distance; where a fit may call itself still it lies up to 0.1 mm before its end
HOLDS = 0.8  # of the most vertices that met the scan; a drag over the whole breast leaves 0.98
RANGES = ("max_distance", "data_sigma", "along_sigma", "landmark_sigma", "kernel_scale")


class FittedScan:
    """One scan with its model, which moves with the picks.  `task` starts where its fit has ended."""

    def __init__(self, task: FitTask) -> None:
        self._fitted = self._task = replace(task, recipe=settled(task.recipe))
        self._coverage = 0.0

    @property
    def task(self) -> FitTask:
        """With the landmarks and the pose of the last move."""
        return self._task

    def moved(self, landmarks: Mapping[str, Array]) -> FitIterate:
        """The model for these picks, {name: (3,) m, in the scan's frame}; its status says whether there is one.

        Where picks have torn it off the scan the next move starts from the fit again.
        """
        *_, last = fit_iterates(replace(self._task, landmarks=dict(landmarks)))
        self._coverage = max(self._coverage, last.coverage)
        holds = last.is_finite and last.coverage > HOLDS * self._coverage
        self._task = replace(self._task, landmarks=dict(landmarks), start=last.parameters) if holds else self._fitted
        return last


def settled(recipe: Recipe, iterations: int = ITERATIONS) -> Recipe:
    """The last stage alone, with every range at its end."""
    last = recipe.stages[-1]
    ends = {name: (value[1], value[1]) for name in RANGES if (value := getattr(last, name)) is not None}
    stage: Stage = last.model_copy(update={**ends, "iterations": iterations, "tighten": 1})
    stop = recipe.stop.model_copy(update={"distance_change_m": STILL})
    return recipe.model_copy(update={"stages": (stage,), "stop": stop})
