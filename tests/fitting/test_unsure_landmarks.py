"""Landmarks that are only proposed: they start the fit, and pull as hard as their confidence says."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.propose import USEFUL, expected_error
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


def test_error_of_a_confidence() -> None:
    assert expected_error(1.0) == 0.0
    assert expected_error(0.5) == pytest.approx(USEFUL)
    errors = [expected_error(share) for share in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)]
    assert errors == sorted(errors, reverse=True)
    assert np.isfinite(errors).all()


def nipple_gap(task: FitTask) -> float:
    """m from the fitted left nipple to the pick."""
    x = list(fit_iterates(task))[-1].parameters
    place = task.rig.landmark_points(("nipple_L",)).positions(pose(task.rig, x), task.rig.faces)[0]
    return float(np.linalg.norm(place - task.landmarks["nipple_L"]))


@pytest.mark.slow
def test_the_less_sure_the_less_followed(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 6)
    wrong = landmarks | {"nipple_L": landmarks["nipple_L"] + [0.0, 0.012, 0.0]}
    task = FitTask(
        torso,
        target,
        start_from_landmarks(torso, wrong),
        load_recipe("default"),
        {},
    ).with_picks(wrong)
    gaps = [nipple_gap(task.with_picks(task.landmarks, {"nipple_L": error})) for error in (0.0, 0.003, 0.01, 0.05)]
    assert gaps == sorted(gaps)
    assert gaps[-1] > 0.010, "hardly followed at all"
    assert gaps[0] == nipple_gap(task) < 0.9 * gaps[-1]


def test_all_unsure_ends_near_the_fit_without_any(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 6)
    moved = {name: place + np.array([0.015, 0.0, 0.0]) for name, place in landmarks.items()}
    start = start_from_landmarks(torso, landmarks)
    recipe = load_recipe("default")
    without = list(fit_iterates(FitTask(torso, target, start, recipe, {})))[-1].parameters
    unsure = FitTask(
        torso,
        target,
        start,
        recipe,
        {},
    ).with_picks(moved, dict.fromkeys(moved, expected_error(0.01)))
    gap = pose(torso, list(fit_iterates(unsure))[-1].parameters) - pose(torso, without)
    assert np.linalg.norm(gap, axis=1).mean() < 0.002
