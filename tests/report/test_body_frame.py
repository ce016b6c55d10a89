"""The patient's frame: her left is +, whatever the scan's own axes are."""

import numpy as np

from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.body_frame import body_frame


def test_left_is_positive_and_both_sides_are_alike_wherever_she_stands() -> None:
    rig = read_rig(default_rig_path())
    turn, shift = exp_so3(np.array([0.3, -1.1, 0.7])), np.array([0.4, -0.2, 1.3])
    vertices = rig.template @ turn.T + shift
    frame = body_frame(rig, vertices)
    lateral = frame.lateral(vertices)
    np.testing.assert_allclose(lateral, rig.template[:, 0], atol=2e-3)
    np.testing.assert_allclose(lateral[rig.mirror_vertices], -lateral, atol=2e-3)
    np.testing.assert_allclose(frame.axes, turn, atol=2e-2)
    np.testing.assert_allclose(frame.lateral(frame.on_plane(vertices)), 0.0, atol=1e-12)
