"""The angle of an arm is that of its bone against the trunk, whatever way the body lies; unseen arms have none."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.geometry.rotations import exp_so3
from breastrig.rig.arms import OF_THE_ARM, arm_angles
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters

SIDEWAYS = np.array([0.0, 0.0, 1.0])


def raised(rig: Rig, degrees: float) -> RigParameters:
    """The left arm turned in the body's plane, away from the trunk."""
    rest = rest_parameters(rig)
    rotations = rest.rotations.copy()
    arm = rig.bone_names.index("upper_arm_L")
    rotations[arm] = exp_so3(np.radians(degrees) * SIDEWAYS) @ rotations[arm]
    return replace(rest, rotations=rotations)


def test_an_arm_that_is_raised_is_farther_by_as_much_and_a_body_that_lies_down_has_the_same_angles(torso: Rig) -> None:
    seen = np.ones(len(torso.template), dtype=np.bool_)
    rest = arm_angles(torso, rest_parameters(torso), seen)
    assert rest["L"] == pytest.approx(rest["R"], abs=0.5)
    assert 5.0 < rest["L"] < 60.0
    up = arm_angles(torso, raised(torso, 40.0), seen)
    assert up["L"] == pytest.approx(rest["L"] + 40.0, abs=3.0)  # not all of it in one plane with the trunk's axis
    assert up["R"] == rest["R"]
    lying = raised(torso, 40.0).moved(exp_so3(np.array([1.2, 0.4, -0.7])), np.array([0.1, 0.2, 0.3]))
    assert arm_angles(torso, lying, seen) == pytest.approx(up)


def test_an_arm_that_the_scan_hardly_shows_has_no_angle(torso: Rig, toy_rig: Rig) -> None:
    seen = torso.skin_weights[:, torso.bone_names.index("upper_arm_R")] < OF_THE_ARM
    assert set(arm_angles(torso, rest_parameters(torso), seen)) == {"L"}
    assert arm_angles(toy_rig, rest_parameters(toy_rig), np.ones(len(toy_rig.template), dtype=np.bool_)) == {}
