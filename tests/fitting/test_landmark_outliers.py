"""Each pick as if it had not been given: the first order against real fits without it, and what is made of it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.landmark_outliers import LeaveOneOut, checked_iterates, contradicted
from breastrig.fitting.orientation import start_from_landmarks
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def task_with(rig: Rig, seed: int, moved: dict[str, Array]) -> FitTask:
    """A patient of the rig with some picks moved by (3,) m."""
    target, landmarks, _ = patient(rig, seed)
    picks = {name: place + moved.get(name, 0.0) for name, place in landmarks.items()}
    return FitTask(rig, target, start_from_landmarks(rig, landmarks), load_recipe("default"), picks)


def left_out_for_real(task: FitTask, name: str) -> float:
    """m from the pick to the landmark of a fit that did not know it."""
    others = {other: place for other, place in task.landmarks.items() if other != name}
    last = list(fit_iterates(replace(task, landmarks=others)))[-1]
    point = task.rig.landmark_points((name,)).positions(pose(task.rig, last.parameters), task.rig.faces)[0]
    return float(np.linalg.norm(point - task.landmarks[name]))


@pytest.mark.parametrize("name", ["nipple_L", "acromion_R", "umbilicus", "xiphoid"])
def test_first_order_agrees_with_a_fit_without_the_pick(torso: Rig, name: str) -> None:
    along = np.array([0.0, 0.010, 0.0])
    task = task_with(torso, 4, {name: along})
    last = list(fit_iterates(task))[-1]
    gap = LeaveOneOut(task, last.parameters).gaps()[name]
    real = left_out_for_real(task, name)
    assert gap == pytest.approx(real, abs=0.0025), "m, of a pick moved by 10 mm"
    own = LeaveOneOut(task, last.parameters).distances[name]
    assert gap > own, "a pick that was followed looks better than it is"


def test_leaving_two_out_is_leaving_one_out_twice(torso: Rig) -> None:
    task = task_with(torso, 4, {"acromion_R": np.array([0.02, 0.0, 0.0])})
    picks = LeaveOneOut(task, list(fit_iterates(task))[-1].parameters)
    assert picks.gaps(without=("nipple_L",))["nipple_L"] == pytest.approx(picks.gaps()["nipple_L"], rel=1e-9)
    alone, both = picks.gaps(), picks.gaps(without=("acromion_R", "acromion_L"))
    assert both["acromion_R"] != pytest.approx(alone["acromion_R"], rel=1e-6)
    assert all(np.isfinite(list(both.values())))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_true_picks_agree(torso: Rig, seed: int) -> None:
    task = task_with(torso, seed, {})
    assert contradicted(task, list(fit_iterates(task))[-1].parameters) is None


@pytest.mark.parametrize(
    "name", ["acromion_L", "suprasternal_notch", "nipple_R", "inframammary_fold_L", "midclavicle_R"]
)
def test_a_pick_far_off_is_let_go_and_the_fit_goes_on(torso: Rig, name: str) -> None:
    task = task_with(torso, 5, {name: np.array([0.05, 0.0, 0.0])})
    iterates = list(checked_iterates(task))
    assert iterates[-1].not_followed == (name,)
    assert [iterate.iteration for iterate in iterates] == list(range(len(iterates)))
    assert all(iterate.status is Status.RUNNING for iterate in iterates[:-1])
    assert iterates[-1].status is Status.CONVERGED
    elapsed = [iterate.elapsed_s for iterate in iterates]
    assert elapsed == sorted(elapsed)
    landmarks = torso.landmark_points((name,)).positions(pose(torso, iterates[-1].parameters), torso.faces)[0]
    true = task.landmarks[name] - [0.05, 0.0, 0.0]
    assert np.linalg.norm(landmarks - true) < 0.015


def test_without_picks_nothing_is_asked(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 1)
    task = FitTask(torso, target, start_from_landmarks(torso, landmarks), load_recipe("default"), {})
    plain, checked = list(fit_iterates(task)), list(checked_iterates(task))
    assert len(plain) == len(checked)
    np.testing.assert_array_equal(plain[-1].parameters.weights, checked[-1].parameters.weights)
