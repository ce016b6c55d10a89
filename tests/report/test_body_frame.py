"""The patient's frame: her left is +, whatever the scan's own axes are."""

import json
from pathlib import Path

import numpy as np

from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.body_frame import body_frame

SHARED = Path(__file__).parents[2] / "web/test/drawing/median_plane.json"  # read by web/test/drawing/mirror.test.ts


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


def test_the_page_mirrors_points_to_where_this_frame_has_them() -> None:
    shared = json.loads(SHARED.read_text("utf-8"))
    rig = read_rig(default_rig_path())
    turn, shift = exp_so3(np.array(shared["turn"])), np.array(shared["shift_m"])
    frame = body_frame(rig, rig.template @ turn.T + shift)
    normal = frame.axes[:, 0]
    assert shared["median_plane"] == {
        "normal": [round(float(value), 9) for value in normal],
        "offset": round(float(normal @ frame.middle), 6),
    }
    here, there = (1e-3 * np.array([pair[name] for pair in shared["pairs_mm"]]) for name in ("point", "mirrored"))
    np.testing.assert_allclose(2.0 * frame.on_plane(here) - here, there, atol=1e-6)
    np.testing.assert_allclose(frame.lateral(there), -frame.lateral(here), atol=1e-6)
