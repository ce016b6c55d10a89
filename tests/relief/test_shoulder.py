"""The tip of a hanging shoulder on simple forms, and none where there is no arm or it does not hang."""

import numpy as np
import pytest
import trimesh

from breastrig.core.arrays import Array
from breastrig.relief.limits import relief
from breastrig.relief.shoulder import ShoulderTip, shoulder_tip

RULES = relief().shoulder
UP = np.array([0.0, 1.0, 0.0])
JOINT = np.array([0.15, 0.0, 0.0])
RADIUS = 0.045  # m, of shoulder and arm


def fine_capsule(length: float) -> trimesh.Trimesh:
    """Along z from the origin, with triangles of 8 mm as a model has them."""
    arm = trimesh.creation.capsule(height=length, radius=RADIUS, count=[48, 48])
    return trimesh.Trimesh(*trimesh.remesh.subdivide_to_size(arm.vertices, arm.faces, 0.008))


def tip_of(length: float, near: Array) -> ShoulderTip | None:
    """Of a capsule that hangs from the joint."""
    arm = fine_capsule(length)
    arm.apply_translation([0.0, 0.0, -0.5 * length])  # its upper ball around the origin
    arm.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2.0, [1.0, 0.0, 0.0]))
    arm.apply_translation(JOINT)
    return shoulder_tip(np.asarray(arm.vertices), np.asarray(arm.faces), near, RULES)


@pytest.mark.parametrize("off", [(0.0, 0.03, 0.0), (0.02, 0.02, 0.02), (-0.01, 0.05, -0.02)])
def test_the_tip_lies_above_the_joint_wherever_the_form_had_it(off: tuple[float, float, float]) -> None:
    found = tip_of(0.25, JOINT + off)
    out, up, front = found.place - JOINT
    assert out == pytest.approx(RADIUS - RULES.edge_beyond, abs=0.003)
    assert front == pytest.approx(RADIUS - RULES.front_before, abs=0.003)
    assert up == pytest.approx(RADIUS, abs=0.002)
    assert found.edge[0] == pytest.approx(JOINT[0] + RADIUS, abs=0.003)
    assert found.front[2] == pytest.approx(RADIUS, abs=0.003)


def test_a_wider_shoulder_has_its_tip_farther_out() -> None:
    narrow = tip_of(0.25, JOINT + RADIUS * UP)
    moved = shoulder_tip(*scaled(1.2), 1.2 * JOINT + RADIUS * UP, RULES)
    assert moved.place[0] > narrow.place[0] + 0.025


def scaled(factor: float) -> tuple[Array, Array]:
    arm = fine_capsule(0.25)
    arm.apply_translation([0.0, 0.0, -0.125])
    arm.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2.0, [1.0, 0.0, 0.0]))
    return factor * (np.asarray(arm.vertices) + JOINT), np.asarray(arm.faces)


def test_without_a_shoulder_around_there_is_no_tip() -> None:
    assert tip_of(0.25, JOINT + 0.5 * UP) is None
    assert shoulder_tip(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), JOINT, RULES) is None
