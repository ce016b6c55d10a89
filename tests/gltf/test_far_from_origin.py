"""Ten kilometres from the origin every .glb that leaves the program is exact to a hundredth of a millimetre."""

import json

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.random_pose import random_parameters
from helpers.toy_rig import toy_rig

from breastrig.core.glb import split_glb
from breastrig.gltf.lines.lines_glb import lines_glb
from breastrig.gltf.link_mesh import plain_mesh
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.gltf.replay import fitted_glb
from breastrig.rig.skinning import pose
from breastrig.scan.clean import Surface

FAR = np.array([10_000.123456789, -4_321.987654321, 8_765.4321])  # m
EXACT = 1e-5  # m
RIG = toy_rig()


def test_the_mesh_for_display() -> None:
    vertices = RIG.template + FAR
    for data in (mesh_glb(vertices, RIG.faces), plain_mesh(Surface(vertices, RIG.faces, ()))):
        np.testing.assert_allclose(GltfScene(data).positions("mesh"), vertices, rtol=0, atol=EXACT)


def test_lines() -> None:
    points = RIG.template[:9] + FAR
    scene = GltfScene(lines_glb([("stroke", points, False, (0, 0, 0)), ("spot", points[:1], False, (0, 0, 0))]))
    np.testing.assert_allclose(scene.positions("stroke"), points, rtol=0, atol=EXACT)
    np.testing.assert_allclose(scene.positions("spot"), points[:1], rtol=0, atol=EXACT)


@pytest.mark.parametrize("drawing", [None, RIG.drawings[0]], ids=["plain", "drawn"])
def test_the_fitted_model_in_its_pose_and_at_every_key(drawing) -> None:
    random = np.random.default_rng(3)
    poses = [random_parameters(RIG, random).moved(np.eye(3), FAR) for _ in range(3)]
    data = fitted_glb(RIG, poses, [0.0, 0.1, 0.2], drawing, {})
    np.testing.assert_allclose(GltfScene(data).positions(RIG.name), pose(RIG, poses[-1]), rtol=0, atol=EXACT)
    for key, x in enumerate(poses):
        found = GltfScene(data).at_key("registration", key).positions(RIG.name)
        np.testing.assert_allclose(found, pose(RIG, x), rtol=0, atol=EXACT)


def test_near_the_origin_nothing_is_moved() -> None:
    files = [mesh_glb(RIG.template + 99.0, RIG.faces), lines_glb([("line", RIG.template[:5] + 99.0, False, (0, 0, 0))])]
    for data in files:
        assert "translation" not in json.dumps(split_glb(data)[0])
    x = random_parameters(RIG, np.random.default_rng(4))
    names = [node["name"] for node in GltfScene(fitted_glb(RIG, [x], [0.0], None, {})).nodes]
    assert len(names) == 1 + 2 * len(RIG.bones)
