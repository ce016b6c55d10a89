"""Each pick as if it had not been given: the first order against real fits without it, and its expected size."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.posterior import LeaveOneOut, Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


def task_with(rig: Rig, seed: int, moved: dict[str, Array]) -> FitTask:
    """A patient of the rig with some picks moved by (3,) m."""
    target, landmarks, _ = patient(rig, seed)
    picks = {name: place + moved.get(name, 0.0) for name, place in landmarks.items()}
    return FitTask(
        rig,
        target,
        start_from_landmarks(rig, landmarks),
        load_recipe("default"),
        {},
    ).with_picks(picks)


def left_out(task: FitTask) -> LeaveOneOut:
    return LeaveOneOut(Posterior(task, list(fit_iterates(task))[-1].parameters))


def left_out_for_real(task: FitTask, name: str) -> float:
    """m from the pick to the landmark of a fit that did not know it, and saw nothing of it on the skin either."""
    others = {other: place for other, place in task.landmarks.items() if other != name}
    last = list(fit_iterates(replace(task.with_picks(others), relief={})))[-1]
    point = task.rig.landmark_points((name,)).positions(pose(task.rig, last.parameters), task.rig.faces)[0]
    return float(np.linalg.norm(point - task.landmarks[name]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nipple_L", "umbilicus"])
def test_first_order_agrees_with_a_fit_without_the_pick(torso: Rig, name: str) -> None:
    task = task_with(torso, 4, {name: np.array([0.0, 0.010, 0.0])})
    picks = left_out(task)
    gap = float(np.linalg.norm(picks.of_model()[name][0]))
    assert gap == pytest.approx(left_out_for_real(task, name), abs=0.0025), "m, of a pick moved by 10 mm"
    assert gap > picks.distances[name], "a pick that was followed looks better than it is"


def test_leaving_two_out_is_leaving_one_out_twice(torso: Rig) -> None:
    picks = left_out(task_with(torso, 4, {"acromion_R": np.array([0.02, 0.0, 0.0])}))
    for measure in (picks.gaps, picks.deviations):
        assert measure(without=("nipple_L",))["nipple_L"] == pytest.approx(measure()["nipple_L"], rel=1e-9)
        alone, both = measure(), measure(without=("acromion_R", "acromion_L"))
        assert both["acromion_R"] != pytest.approx(alone["acromion_R"], rel=1e-6)
        assert all(np.isfinite(list(both.values())))


def test_a_pick_said_to_be_unsure_deviates_less_for_the_same_distance(torso: Rig) -> None:
    task = task_with(torso, 4, {"nipple_L": np.array([0.02, 0.0, 0.0])})
    unsure = task.with_picks(task.landmarks, {"nipple_L": 0.01})
    assert left_out(unsure).gaps()["nipple_L"] == pytest.approx(left_out(task).gaps()["nipple_L"], abs=0.004)
    assert left_out(unsure).deviations()["nipple_L"] < 0.7 * left_out(task).deviations()["nipple_L"]


def test_deviations_are_in_standard_deviations(torso: Rig) -> None:
    """On patients that the model can show and picks as good as is said, nothing but the scan's noise is left."""
    found = [value for seed in (1, 2, 3) for value in left_out(task_with(torso, seed, {})).deviations().values()]
    assert 0.1 < float(np.mean(found)) < np.sqrt(3.0)
    assert max(found) < 4.0
