"""Limits and expected sizes of one stance: data beside the rig, nothing of which another stance sees."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.errors import BadModel
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.stance_priors import in_stance, mean_weights, rest_turns


def test_other_stances_see_the_rig_itself() -> None:
    rig = read_rig(default_rig_path())
    for stance in ("standing", "supine"):
        assert in_stance(rig, stance) is rig
        assert not mean_weights(rig, stance).any()
        assert rest_turns(rig, stance) is None


def test_both_sides_of_a_stance_are_mirrored() -> None:
    rig = read_rig(default_rig_path())
    prone, turns, means = in_stance(rig, "prone"), rest_turns(rig, "prone"), mean_weights(rig, "prone")
    assert turns is not None
    by_name = dict(zip(rig.shape_names, zip(prone.shapes, means, strict=True), strict=True))
    for name, (shape, mean) in by_name.items():
        partner, partners_mean = by_name[shape.mirror]
        assert (shape.min, shape.max, shape.sigma, mean) == (partner.min, partner.max, partner.sigma, partners_mean), (
            name
        )
        assert shape.min <= mean <= shape.max
    arms = {rig.bone_names[joint.child]: turn for joint, turn in zip(rig.joints, turns, strict=True)}
    np.testing.assert_array_equal(arms["upper_arm_L"], [1.0, -1.0, -1.0] * arms["upper_arm_R"])


def test_a_wrong_number_is_named() -> None:
    rig = replace(read_rig(default_rig_path()), known={"priors_prone.toml": "[shapes]\nptosis = { sigma = -1 }"})
    with pytest.raises(BadModel, match=r"priors_prone.toml cannot be used: shapes.ptosis.sigma"):
        in_stance(rig, "prone")
