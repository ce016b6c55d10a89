"""Where landmarks are expected beside the fitted model's: numbers with a side, on both sides and on a turned body."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from breastrig.fitting.body.expected_shifts import (
    MIDDLE,
    NOTCH,
    XIPHOID,
    expected_shifts,
    mid_sternum_step,
    standing_shifts,
)
from breastrig.fitting.body.hanging import hanging_misfit, hanging_shifts
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.limits import relief
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState

TURN = exp_so3(np.array([1.2, -0.4, 0.3]))
RIG = read_rig(default_rig_path())
RECIPE = load_recipe("default")
FOLDS = ("inframammary_fold_L", "inframammary_fold_R")
MIRROR = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])  # body frame: +X is the patient's left


def task(stance: str, *picked: str) -> Any:
    return SimpleNamespace(stance=stance, landmarks=dict.fromkeys(picked, np.zeros(3)), rig=RIG, recipe=RECIPE)


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
def test_standing_folds_are_expected_farther_out_on_each_side(turn: np.ndarray) -> None:
    outwards = np.array(RECIPE.landmark_errors(FOLDS[0]).standing_shift)
    assert outwards[0] > 0.003
    shifts = standing_shifts(RIG.template @ turn.T + 0.2, task("standing"), FOLDS)
    np.testing.assert_allclose(shifts, (MIRROR * outwards) @ turn.T, atol=1e-9)


def test_nothing_is_added_to_a_pick_nor_in_another_stance() -> None:
    assert not standing_shifts(RIG.template, task("supine"), FOLDS).any()
    left, right = standing_shifts(RIG.template, task("standing", FOLDS[0]), FOLDS)
    assert not left.any()
    assert right[0] < -0.003


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
def test_a_hanging_fold_is_expected_farther_out_on_its_own_side_alone(turn: np.ndarray) -> None:
    hanging = RECIPE.hanging
    assert hanging is not None
    known = RECIPE.landmark_errors(FOLDS[0])
    outwards, spread = np.array(known.hanging_shift), np.array(known.hanging)
    assert outwards[0] > 0.001
    for own, side in enumerate(("_L", "_R")):
        weights = np.zeros(len(RIG.shape_names))
        weights[RIG.shape_names.index(hanging.shape + side)] = 0.5
        state = BodyState(RIG, replace(rest_parameters(RIG), weights=weights).moved(turn, np.zeros(3)))
        for number, name in enumerate(FOLDS):
            shift, covariance = hanging_misfit(state, RECIPE, name)
            share = 0.5 if number == own else 0.0
            np.testing.assert_allclose(shift, turn @ (share * MIRROR[number] * outwards), atol=2e-4)
            np.testing.assert_allclose(covariance, turn @ (share**2 * np.diag(spread**2)) @ turn.T, atol=2e-6)


def test_without_picks_only_the_side_that_was_seen_to_hang_counts() -> None:
    hanging = RECIPE.hanging
    assert hanging is not None
    weights = np.zeros(len(RIG.shape_names))
    weights[[RIG.shape_names.index(f"{hanging.shape}_{side}") for side in "LR"]] = hanging.weight
    state = BodyState(RIG, replace(rest_parameters(RIG), weights=weights))

    def moved(seen: tuple[str, ...], *picked: str) -> list[bool]:
        asked = SimpleNamespace(**vars(task("standing", *picked)), hanging=seen)
        return np.any(hanging_shifts(state, asked, FOLDS) != 0.0, axis=1).tolist()

    assert moved(()) == [False, False]
    assert moved((f"{hanging.shape}_L",)) == [True, False]
    assert moved((f"{hanging.shape}_R",)) == [False, True]
    assert moved((), "xiphoid") == [True, True]
    assert moved((), FOLDS[0]) == [False, True]


def test_the_middle_of_the_breastbone_is_expected_along_the_line_between_its_ends_as_observed() -> None:
    state = BodyState(RIG, rest_parameters(RIG))
    places = RIG.landmark_points().positions(state.vertices, RIG.faces)
    at = dict(zip(RIG.landmark_names, places, strict=True))
    seen = {XIPHOID: at[XIPHOID] - np.array([0.0, 0.02, 0.0])}
    for observed in ({}, seen):
        now = at | observed
        step = mid_sternum_step(now[NOTCH], now[XIPHOID], now[MIDDLE], relief().mid_sternum)
        assert np.linalg.norm(step) > 1e-4
        moved = expected_shifts(places, state, SimpleNamespace(**vars(task("supine")), hanging=()), observed)
        np.testing.assert_allclose(moved, [step if name == MIDDLE else np.zeros(3) for name in RIG.landmark_names])
    picked = SimpleNamespace(**vars(task("supine", MIDDLE)), hanging=())
    assert not expected_shifts(places, state, picked, seen).any()
