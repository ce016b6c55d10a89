"""The page poses rigs by dual quaternions itself: what it must come to, in a file that its own test reads."""

import base64
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from helpers.random_pose import random_parameters
from helpers.toy_rig import toy_rig

from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.iterate import model_buffer
from breastrig.gltf.pose_nodes import node_poses, posed_by_nodes
from breastrig.gltf.write_rig import rig_glb
from breastrig.rig.skinning import pose

SHARED = Path(__file__).parents[2] / "web/test/fit/dual_quaternions.json"  # read by web/test/fit/TorsoModel.test.ts
RIG = replace(toy_rig(), skinning="dual_quaternion")


def test_what_the_pages_test_expects_is_what_the_service_poses() -> None:
    shared = json.loads(SHARED.read_text("utf-8"))
    model = base64.b64decode(shared["glb"])
    assert model.endswith(model_buffer(RIG))  # what stands before it names the version
    for one in shared["poses"]:
        there = pose(RIG, posed_by_nodes(RIG, one["nodes"]))
        np.testing.assert_allclose(one["vertices"], there, atol=1e-6)
        assert np.abs(there - pose(toy_rig(), posed_by_nodes(RIG, one["nodes"]))).max() > 0.01  # and not linear


def _write() -> None:
    """python tests/gltf/test_page_skinning.py: after a change of the toy rig."""
    random = np.random.default_rng(8)
    poses = []
    for move in (np.zeros(3), np.array([3.0, -20.0, 1.5])):
        x = random_parameters(RIG, random, turn=1.2).moved(exp_so3(random.normal(size=3)), move)
        nodes = node_poses(RIG, x)
        poses.append({"nodes": nodes, "vertices": np.round(pose(RIG, posed_by_nodes(RIG, nodes)), 7).tolist()})
    shared = {"glb": base64.b64encode(rig_glb(RIG)).decode(), "poses": poses}
    SHARED.write_text(json.dumps(shared, separators=(",", ":")) + "\n", "utf-8")


if __name__ == "__main__":
    sys.exit(_write())
