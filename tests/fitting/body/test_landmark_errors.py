"""Where landmarks of bodies lie beside the model's: on both sides, on a turned body, and as a rig has them."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.core.stances import split_side
from breastrig.fitting.body.landmarks import (
    MIDDLE,
    NOTCH,
    UNKNOWN,
    XIPHOID,
    expected_gaps,
    landmark_errors,
    middle_step,
)
from breastrig.fitting.posterior import expected_places
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.limits import relief
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState
from breastrig_studies.landmark_errors import Residual, estimate

TURN = exp_so3(np.array([1.2, -0.4, 0.3]))
RIG = read_rig(default_rig_path())


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
@pytest.mark.parametrize("stance", ["standing", "supine", "prone"])
def test_both_sides_are_alike_on_a_body_that_is_turned(turn: np.ndarray, stance: str) -> None:
    known = landmark_errors(RIG, stance)
    assert known
    gaps = expected_gaps(BodyState(RIG, rest_parameters(RIG).moved(turn, np.full(3, 0.2))), stance)
    for name, gap in gaps.items():
        stem, side = split_side(name)
        if stem not in known:
            continue
        own = turn @ np.diag([-1.0 if side == "R" else 1.0, 1.0, 1.0])  # body frame: +X is the patient's left
        np.testing.assert_allclose(gap.mean, own @ (1e-3 * np.array(known[stem].mean_mm)), atol=1e-9)
        variances = np.diag((1e-3 * np.array(known[stem].deviation_mm)) ** 2)
        np.testing.assert_allclose(gap.covariance, own @ variances @ own.T, atol=1e-12)
        assert side or known[stem].mean_mm[0] == 0.0


def test_of_a_rig_of_which_nothing_is_known_landmarks_are_expected_where_it_has_them() -> None:
    rig = toy_rig()
    for gap in expected_gaps(BodyState(rig, rest_parameters(rig)), "standing").values():
        assert not gap.mean.any()
        np.testing.assert_allclose(gap.covariance, (1e-3 * UNKNOWN) ** 2 * np.eye(3), atol=1e-15)
    one = replace(rig, landmarks=rig.landmarks[:1])  # its axes are not known
    assert {*expected_gaps(BodyState(one, rest_parameters(one)), "supine")} == {rig.landmark_names[0]}


def test_mean_and_deviation_are_those_of_most_whatever_few_are() -> None:
    rng = np.random.default_rng(4)
    mean, deviation, noise = np.array([0.004, -0.006, 0.0]), np.array([0.003, 0.008, 0.001]), 0.002
    gaps = mean + rng.normal(size=(400, 3)) * np.hypot(deviation, noise)
    unlike = gaps[:20] + np.array([0.0, 0.0, 0.08])
    found = [Residual("a", gap, np.full(3, noise**2)) for gap in (*gaps, *unlike)]
    of_most, spread = estimate(found)
    np.testing.assert_allclose(of_most, mean, atol=1e-3)
    assert (spread > 0.6 * deviation).all()
    assert (spread < 1.3 * deviation + 1e-3).all()
    twice = [*found, *(replace(each, group="b", gap=-each.gap) for each in found[:40])]
    np.testing.assert_allclose(estimate(twice)[0], 0.0, atol=2e-3)  # groups have the same say


@pytest.mark.parametrize("share", [0.2, 0.49, 0.7])
def test_the_middle_of_the_breastbone_goes_along_it_by_its_share_of_what_it_is_off(share: float) -> None:
    notch, xiphoid, aside = np.array([0.0, 0.2, 0.0]), np.array([0.0, 0.0, 0.05]), np.array([0.004, 0.0025, 0.01])
    places = {NOTCH: notch, XIPHOID: xiphoid, MIDDLE: notch + share * (xiphoid - notch) + aside}
    rules = relief().mid_sternum
    np.testing.assert_allclose(middle_step(places), rules.share * (rules.at - share) * (xiphoid - notch), atol=1e-15)
    assert not middle_step(places | {XIPHOID: notch}).any()


def test_a_middle_of_the_breastbone_that_colour_shows_stays_where_it_is_seen() -> None:
    state, cross = BodyState(RIG, rest_parameters(RIG)), np.array([0.0, 1.25, 0.2])
    task = SimpleNamespace(rig=RIG, stance="standing", landmarks={})
    posterior: Any = SimpleNamespace(task=task, state=state, relief={})
    middle = RIG.landmark_names.index(MIDDLE)
    np.testing.assert_array_equal(expected_places(posterior, {MIDDLE: cross})[middle], cross)
    alone = expected_places(posterior, {})
    assert not np.allclose(alone[middle], cross)
