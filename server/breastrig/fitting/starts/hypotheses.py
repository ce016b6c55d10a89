"""Several starts of one scan, each fitted until it cannot win any more; what the best has fitted is not fitted again.

They are compared by the energy at the end of what opens a fit (the stages before its last, docs/decisions/0009).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hanging import opening_of
from breastrig.fitting.fit import InitialPoint, ScanProblem, iterates
from breastrig.fitting.recipe import Recipe, Stage, load_recipe
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.similarity import Similarity, similar_parameters
from breastrig.rig.state import BodyState

GOING_ON = 2  # hypotheses, after the first stage


@dataclass(frozen=True, eq=False)
class Opening:
    """The stages that open a task's fit, as far as they were gone through."""

    problem: ScanProblem
    iterates: tuple[FitIterate, ...] = ()
    place: Similarity | None = None  # of the rest pose, where it began

    @property
    def task(self) -> FitTask:
        return self.problem.task

    @property
    def energy(self) -> float:
        """inf where it broke down or found no skin."""
        return self.iterates[-1].energy if self.iterates[-1].is_finite else np.inf

    def after(self, stage: Stage) -> "Opening":
        """One stage further."""
        if not self.iterates:
            return replace(self, iterates=tuple(iterates(self.problem, [stage])))
        *before, last = self.iterates
        if not last.is_finite:
            return self
        at = InitialPoint(BodyState(self.task.rig, last.parameters), last.energy, last.iteration)
        return replace(self, iterates=(*before, *iterates(self.problem, [stage], at)))


def judge() -> Recipe:
    """The settings by which starts are judged, whatever those of the fit: the place belongs to the scan."""
    return load_recipe("default")


def ranked(rig: Rig, target: ScanTarget, places: Sequence[Similarity], stance: str) -> list[Opening]:
    """Openings from the rest pose at these places, the best first; those behind have not gone to the end."""
    stages = opening_of(judge())
    tasks = [FitTask(rig, target, similar_parameters(rig, place), judge(), {}, stance) for place in places]
    left = [Opening(ScanProblem(task), place=place) for task, place in zip(tasks, places, strict=True)]
    behind: list[Opening] = []
    for stage in stages:
        left = sorted((each.after(stage) for each in left), key=lambda each: each.energy)
        left, behind = left[:GOING_ON], [*left[GOING_ON:], *behind]
    return [*left, *behind]
