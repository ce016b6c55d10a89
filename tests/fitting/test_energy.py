"""Energies that can be compared: what is thrown out has its price, so being far off is dearer than being near."""

import numpy as np
import pytest
from helpers.example_fit import example_task

from breastrig.fitting.fit import ScanProblem, fit_iterates
from breastrig.fitting.task import FitTask
from breastrig.rig.parameters import RigParameters
from breastrig.rig.state import BodyState


@pytest.fixture(scope="module")
def task() -> FitTask:
    return example_task().with_picks({})


@pytest.fixture(scope="module")
def fitted(task: FitTask) -> RigParameters:
    *_, last = fit_iterates(task)
    return last.parameters


def energy(task: FitTask, x: RigParameters) -> float:
    problem, stage, state = ScanProblem(task), task.recipe.stages[1], BodyState(task.rig, x)
    return problem.energy(problem.terms(stage, 1.0, state, problem.matches(stage, 1.0, state)), state)


@pytest.mark.parametrize(("axis", "sign"), [(0, 1.0), (1, -1.0), (2, 1.0)])
def test_the_farther_a_fit_is_pushed_off_the_dearer_it_is(
    axis: int, sign: float, task: FitTask, fitted: RigParameters
) -> None:
    steps = [0.0, 0.005, 0.010, 0.020, 0.040, 0.080, 0.160]  # m; beyond 40 mm it leaves the scan to one side
    dear = [energy(task, fitted.moved(np.eye(3), sign * step * np.eye(3)[axis])) for step in steps]
    assert dear[:5] == sorted(dear[:5])
    assert min(dear[5:]) > dear[1]
