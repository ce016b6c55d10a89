"""A viewer of our files draws what rig/skinning.py computes, to a micrometre."""

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.random_pose import random_parameters, skinned_by
from helpers.toy_rig import toy_rig

from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.iterate import drawing_buffer, iterate_gltf, model_buffer
from breastrig.gltf.pose_nodes import node_poses
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import KEY_SPACING, fitted_glb
from breastrig.gltf.write_rig import rig_glb
from breastrig.rig.model import Rig, Skinning
from breastrig.rig.modes import mode_count
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose

MICROMETRE = 1e-6


@pytest.fixture(scope="module", params=["toy", "torso", "dual quaternions", "correctives"])
def rig(request: pytest.FixtureRequest) -> Rig:
    """Viewers skin linearly: for dual quaternions there are layers, correctives are shapes of their own."""
    if request.param == "toy":
        return toy_rig()
    torso = read_rig(default_rig_path())
    ways: dict[str, Skinning] = {"dual quaternions": "dual_quaternion", "correctives": "corrective"}
    return skinned_by(torso, ways.get(request.param, "linear"))


def somewhere(rig: Rig, seed: int) -> RigParameters:
    """A pose with open joints and non-uniform scales, turned and moved about the room."""
    rng = np.random.default_rng(seed)
    own = random_parameters(rig, rng, turn=0.3, move=0.02, scale=0.3, shape=1.0)
    return own.moved(exp_so3(rng.normal(size=3)), rng.uniform(-1.0, 1.0, 3))


def largest_gap(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.linalg.norm(found - wanted, axis=1).max())


def test_the_model_file_stands_at_rest(rig: Rig) -> None:
    scene = GltfScene(rig_glb(rig))
    assert largest_gap(scene.positions(rig.name), rig.template) < MICROMETRE


@pytest.mark.parametrize("seed", [2])
def test_an_iteration_file_is_posed_as_in_python(rig: Rig, seed: int) -> None:
    x = somewhere(rig, seed)
    text = iterate_gltf(rig, x, None, "model.bin", None)
    scene = GltfScene(text, {"model.bin": model_buffer(rig)})
    assert largest_gap(scene.positions(rig.name), pose(rig, x)) < MICROMETRE


def test_an_iteration_file_has_the_smooth_modes_as_a_layer(rig: Rig) -> None:
    x = somewhere(rig, 2)
    x = replace(x, modes=np.random.default_rng(3).normal(size=mode_count(rig)))
    drawing = rig.drawings[0]
    text = iterate_gltf(rig, x, drawing, "model.bin", "drawing.bin")
    scene = GltfScene(text, {"model.bin": model_buffer(rig), "drawing.bin": drawing_buffer(rig, drawing)})
    assert largest_gap(scene.positions(rig.name), pose(rig, x)) < MICROMETRE
    names = [mesh["extras"]["targetNames"][-1] for mesh in scene.document["meshes"]]
    assert ("skin_layer" in names) == (mode_count(rig) > 0 or rig.skinning == "dual_quaternion")


def test_an_iteration_file_includes_the_drawing(rig: Rig) -> None:
    drawing = rig.drawings[0]
    text = iterate_gltf(rig, somewhere(rig, 1), drawing, "model.bin", "drawing.bin")
    scene = GltfScene(text, {"model.bin": model_buffer(rig), "drawing.bin": drawing_buffer(rig, drawing)})
    node = scene.node(f"drawing_{drawing.name}")
    assert node["weights"] == scene.node(rig.name)["weights"]
    assert scene.document["asset"]["extras"]["notice"].startswith("Research use only")


def test_iterations_share_their_buffers_and_differ_in_nodes_only() -> None:
    rig = toy_rig()
    drawing = rig.drawings[0]
    documents = [json.loads(iterate_gltf(rig, somewhere(rig, seed), drawing, "m", "d")) for seed in (1, 2)]
    for document in documents:
        assert [buffer["uri"][:5] for buffer in document["buffers"]] == ["m", "d", "data:"]
        positions = [line["attributes"]["POSITION"] for line in document["meshes"][1]["primitives"]]
        views = {document["accessors"][place]["bufferView"] for place in positions}
        own = {view for view, entry in enumerate(document["bufferViews"]) if entry["buffer"] == 2}
        assert own == views  # only the drawing's positions lie in the file itself
    first, second = documents
    assert first["nodes"] != second["nodes"]
    for document in documents:
        for place in positions:
            document["accessors"][place].update(min=None, max=None)
        del document["nodes"], document["buffers"][2]["uri"]
    assert first == second


def test_the_model_buffer_is_the_binary_chunk_of_the_model_file() -> None:
    rig = toy_rig()
    assert rig_glb(rig).endswith(model_buffer(rig))


def test_a_fitted_file_is_posed_as_the_last_iterate(rig: Rig) -> None:
    iterates = [somewhere(rig, seed) for seed in range(3)]
    scene = GltfScene(fitted_glb(rig, iterates, [0.0, 0.1, 0.2], rig.drawings[0], {"preset": "default"}))
    assert largest_gap(scene.positions(rig.name), pose(rig, iterates[-1])) < MICROMETRE
    assert scene.document["asset"]["extras"]["preset"] == "default"


@pytest.mark.parametrize("key", [1, -1])
def test_each_key_of_the_animation_is_one_iterate(rig: Rig, key: int) -> None:
    iterates = [somewhere(rig, seed) for seed in range(3)]
    scene = GltfScene(fitted_glb(rig, iterates, [0.0, 0.1, 0.2], rig.drawings[0], {}))
    moved = scene.at_key("registration", key)
    assert largest_gap(moved.positions(rig.name), pose(rig, iterates[key])) < MICROMETRE
    assert moved.node(f"drawing_{rig.drawings[0].name}")["weights"] == moved.node(rig.name)["weights"]


def test_animation_times_grow_even_when_the_fit_was_faster_than_the_clock() -> None:
    rig = toy_rig()
    scene = GltfScene(fitted_glb(rig, [rest_parameters(rig)] * 4, [0.0, 0.0, 0.5, 0.5], None, {}))
    animation = scene.document["animations"][0]
    times = scene.arrays.read(animation["samplers"][0]["input"])
    np.testing.assert_allclose(times, np.cumsum([0.0, KEY_SPACING, 0.5, KEY_SPACING]), atol=1e-6)
    assert animation["extras"]["elapsed_s"] == [0.0, 0.0, 0.5, 0.5]


def test_quaternion_keys_never_take_the_long_way() -> None:
    rig = toy_rig()
    turns = [
        rest_parameters(rig).moved(exp_so3(np.array([0.0, angle, 0.0])), np.zeros(3))
        for angle in np.linspace(0.0, 2.0 * np.pi, 9)
    ]
    scene = GltfScene(fitted_glb(rig, turns, np.arange(9.0), None, {}))
    animation = scene.document["animations"][0]
    root = scene.nodes.index(scene.node(rig.bone_names[0]))
    channel = next(c for c in animation["channels"] if c["target"] == {"node": root, "path": "rotation"})
    keys = scene.arrays.read(animation["samplers"][channel["sampler"]]["output"])
    assert (np.einsum("ki,ki->k", keys[1:], keys[:-1]) > 0.9).all()


def test_a_stream_of_node_poses_names_every_bone_its_scale_and_the_mesh() -> None:
    rig = toy_rig()
    poses = node_poses(rig, somewhere(rig, 5))
    assert [pose["name"] for pose in poses] == [name for bone in rig.bone_names for name in (bone, f"{bone}_scale")] + [
        rig.name
    ]
    assert all(round(value, 7) == value for pose in poses for key in pose if key != "name" for value in pose[key])


def test_the_root_bone_is_absolute_in_the_frame_of_the_scan() -> None:
    rig = toy_rig()
    x = somewhere(rig, 6)
    assert node_poses(rig, x)[0]["translation"] == pytest.approx(x.translations[0], abs=1e-7)
