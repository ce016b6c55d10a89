"""fitted.glb shows the skin where the free-form layer has it, in the last pose, with the drawing on it."""

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.random_pose import random_parameters
from helpers.toy_rig import toy_rig

from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.lines.drawing_node import drawing_node
from breastrig.gltf.lines.ribbon import LIFT, ribbons
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import SKIN_LAYER, fitted_glb
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

MICROMETRE = 1e-6


@pytest.fixture(scope="module", params=["toy", "torso"])
def rig(request: pytest.FixtureRequest) -> Rig:
    return toy_rig() if request.param == "toy" else read_rig(default_rig_path())


@pytest.fixture(scope="module")
def poses(rig: Rig) -> list[RigParameters]:
    rng = np.random.default_rng(11)
    return [random_parameters(rig, rng) for _ in range(3)]


@pytest.fixture(scope="module")
def skin(rig: Rig, poses: list[RigParameters]) -> np.ndarray:
    """The last pose, up to 5 mm off along its normals, smoothly."""
    model = pose(rig, poses[-1])
    heights = 0.005 * np.sin(20.0 * model[:, 0]) * np.cos(15.0 * model[:, 1])
    return np.asarray(model + heights[:, None] * vertex_normals(model, rig.faces))


def written(rig: Rig, poses: list[RigParameters], skin: np.ndarray) -> GltfScene:
    return GltfScene(fitted_glb(rig, poses, [0.0, 0.1, 0.2], rig.drawings[0], {}, skin))


def test_the_file_shows_the_layer_as_it_stands_and_at_the_animations_end(
    rig: Rig, poses: list[RigParameters], skin: np.ndarray
) -> None:
    for scene in (written(rig, poses, skin), written(rig, poses, skin).at_key("registration", -1)):
        assert np.abs(scene.positions(rig.name) - skin).max() < MICROMETRE
        mesh = scene.document["meshes"][scene.node(rig.name)["mesh"]]
        assert mesh["extras"]["targetNames"] == [*rig.shape_names, SKIN_LAYER]


def test_before_the_end_the_layer_is_off(rig: Rig, poses: list[RigParameters], skin: np.ndarray) -> None:
    for key in (0, 1):
        scene = written(rig, poses, skin).at_key("registration", key)
        assert np.abs(scene.positions(rig.name) - pose(rig, poses[key])).max() < MICROMETRE


def test_the_drawing_lies_on_the_layer(rig: Rig, poses: list[RigParameters], skin: np.ndarray) -> None:
    lines = written(rig, poses, skin).positions(drawing_node(rig.drawings[0].name))
    places, normals = [], vertex_normals(skin, rig.faces)
    for ribbon in ribbons(rig, rig.drawings[0]):
        lifted = LIFT * ribbon.points.directions(normals, rig.faces)
        places.append(ribbon.points.positions(skin, rig.faces) + lifted)
    assert np.abs(lines - np.concatenate(places)).max() < 5 * MICROMETRE


def test_far_from_the_origin_the_layer_stays_where_it_is(
    rig: Rig, poses: list[RigParameters], skin: np.ndarray
) -> None:
    far = np.array([10_000.5, -300.25, 7_000.125])
    scene = written(rig, [x.moved(np.eye(3), far) for x in poses], skin + far)
    assert np.abs(scene.positions(rig.name) - (skin + far)).max() < 5 * MICROMETRE
