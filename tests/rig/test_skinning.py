"""All ways of skinning: their derivative, what they share, and what dual quaternions keep."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.random_pose import random_parameters, skinned_by

from breastrig.core.errors import BadModel
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig, Skinning
from breastrig.rig.named_parameters import sampled
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import Posed, in_pose, pose
from breastrig_studies.output.rig_files import write_rig

WAYS: tuple[Skinning, ...] = ("linear", "dual_quaternion", "corrective")


@pytest.mark.parametrize("skinning", WAYS)
def test_rows_are_the_finite_differences_in_every_unknown(skinning: Skinning, torso: Rig, toy_rig: Rig) -> None:
    rng = np.random.default_rng(3)
    for rig in (skinned_by(torso, skinning), skinned_by(toy_rig, skinning)):
        x = random_parameters(rig, rng, turn=1.0)
        chosen = rng.integers(0, len(rig.template), 60)
        directions = rng.normal(size=(len(chosen), 3))
        small = 1e-5 * np.eye(x.dof)
        ahead, behind = (np.array([pose(rig, x.retract(sign * step))[chosen] for step in small]) for sign in (1, -1))
        slopes = np.einsum("pmi,mi->mp", ahead - behind, directions) / 2e-5
        np.testing.assert_allclose(in_pose(rig, x).rows(chosen, directions), slopes, atol=1e-8)


def test_a_rig_keeps_its_skinning_in_its_side_file_and_another_word_is_one_sentence(
    toy_rig: Rig, tmp_path: Path
) -> None:
    for skinning in WAYS:
        rig = skinned_by(toy_rig, skinning)
        write_rig(rig, tmp_path)
        read = read_rig(tmp_path / "toy.glb")
        assert (read.skinning, read.shape_names) == (skinning, rig.shape_names)
        x = random_parameters(rig, np.random.default_rng(2), turn=1.0)
        np.testing.assert_allclose(pose(read, x), pose(rig, x), atol=1e-6)
    file = tmp_path / "toy.json"
    for word, expected in (
        ("spherical", r"^toy.json .*skinning.*'linear', 'dual_quaternion' or 'corrective'.*\.$"),
        (
            "linear",
            '^The side file says "skinning": "corrective" if and only if it lists correctives.$',
        ),
    ):
        file.write_text(re.sub('"skinning": "[a-z]*"', f'"skinning": "{word}"', file.read_text("utf-8")), "utf-8")
        with pytest.raises(BadModel, match=expected):
            read_rig(tmp_path / "toy.glb")


@pytest.mark.parametrize("skinning", WAYS)
def test_the_linear_map_takes_moves_at_rest_to_moves_of_the_skin(skinning: Skinning, torso: Rig) -> None:
    rig = skinned_by(torso, skinning)
    x = random_parameters(rig, np.random.default_rng(4), turn=1.0)
    move = 1e-3 * np.random.default_rng(5).normal(size=rig.template.shape)
    moved = pose(replace(rig, template=rig.template + move), x) - pose(rig, x)
    np.testing.assert_allclose(np.einsum("vij,vj->vi", in_pose(rig, x).linear, move), moved, atol=1e-12)


def test_scales_alone_rigid_motions_and_single_bones_are_the_same_in_both(torso: Rig) -> None:
    other, rng = replace(torso, skinning="dual_quaternion"), np.random.default_rng(6)
    scaled = random_parameters(torso, rng, turn=0.0, move=0.0)
    rigid = scaled.moved(exp_so3(np.array([2.0, -1.5, 0.7])), np.array([40.0, -3.0, 7.0]))
    for x in (rest_parameters(torso), scaled, rigid):
        np.testing.assert_allclose(pose(other, x), pose(torso, x), atol=1e-12)
    x = random_parameters(torso, rng, turn=1.0)
    single = np.eye(len(torso.bones))[torso.skin_weights.argmax(axis=1)]
    alone = [pose(replace(rig, skin_weights=single), x) for rig in (torso, other)]
    np.testing.assert_allclose(alone[0], alone[1], atol=1e-12)


def test_a_twisted_bone_keeps_its_girth_only_by_dual_quaternions(torso: Rig) -> None:
    """Two bones at one place, one of them turned about the other's long axis by 150 degrees: half way between."""
    bones = (torso.bones[0], replace(torso.bones[0], name="twisted"))
    rig = replace(torso, bones=bones, skin_weights=np.full((len(torso.template), 2), 0.5))
    rest = rest_parameters(rig)
    turn = exp_so3(np.radians([0.0, 150.0, 0.0]))
    x = replace(rest, rotations=np.array([rest.rotations[0], turn @ rest.rotations[1]]))
    half = exp_so3(np.radians([0.0, 75.0, 0.0]))
    origin = rig.rest_origins[0]
    expected = (rig.template - origin) @ half.T + origin
    np.testing.assert_allclose(pose(replace(rig, skinning="dual_quaternion"), x), expected, atol=1e-12)
    away = (Posed(rig, x).vertices - origin)[:, [0, 2]]
    np.testing.assert_allclose(away, (expected - origin)[:, [0, 2]] * np.cos(np.radians(75.0)), atol=1e-12)


def test_a_sampled_body_is_within_the_rigs_limits_and_reaches_both(toy_rig: Rig) -> None:
    shapes = tuple(replace(shape, min=-shape.sigma, max=shape.sigma) for shape in toy_rig.shapes)
    tight = replace(toy_rig, shapes=shapes)
    rng = np.random.default_rng(0)
    drawn = np.array([list(sampled(tight, rng).blendshapes.values()) for _ in range(40)])
    limits = np.array([shape.sigma for shape in tight.shapes])
    np.testing.assert_allclose(drawn.max(axis=0), limits)
    np.testing.assert_allclose(drawn.min(axis=0), -limits)
    assert (np.abs(drawn) < 0.99 * limits).any()
