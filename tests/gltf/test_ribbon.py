"""The drawing in a glTF lies on the skin of the posed model, as the exact surface points do."""

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.random_pose import random_parameters
from helpers.toy_rig import toy_rig

from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.iterate import drawing_buffer, iterate_gltf, model_buffer
from breastrig.gltf.lines.ribbon import LIFT, STEP, WIDTH, Ribbon, ribbons
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import fitted_glb
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose


@pytest.fixture(scope="module", params=["toy", "torso"])
def rig(request: pytest.FixtureRequest) -> Rig:
    return toy_rig() if request.param == "toy" else read_rig(default_rig_path())


def lines(rig: Rig) -> tuple[Ribbon, ...]:
    return ribbons(rig, rig.drawings[0])


def pose_of_a_patient(rig: Rig, seed: int) -> RigParameters:
    """Bones turned by some degrees and scaled by some per cent, joints open by millimetres, all shapes in use."""
    return random_parameters(rig, np.random.default_rng(seed), turn=0.07, move=0.003, scale=0.1, shape=0.5)


def any_pose(rig: Rig, seed: int) -> RigParameters:
    """Far beyond any patient."""
    return random_parameters(rig, np.random.default_rng(seed), turn=0.3, move=0.02, scale=0.3, shape=1.0)


def gaps_mm(scene: GltfScene, rig: Rig, drawing: ModelDrawing, x: RigParameters) -> np.ndarray:
    """How far each ribbon vertex is drawn from its exact place over the posed mesh."""
    mesh = pose(rig, x)
    normals = vertex_normals(mesh, rig.faces)
    exact = []
    for line in ribbons(rig, drawing):
        facing = line.points.positions(normals, rig.faces)
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        exact.append(line.points.positions(mesh, rig.faces) + LIFT * facing)
    return 1e3 * np.linalg.norm(scene.positions(f"drawing_{drawing.name}") - np.concatenate(exact), axis=1)


@pytest.mark.parametrize("seed", [1])
def test_the_drawing_of_a_fitted_file_is_exact(rig: Rig, seed: int) -> None:
    x = any_pose(rig, seed)
    for drawing in rig.drawings:
        scene = GltfScene(fitted_glb(rig, [any_pose(rig, seed + 1), x], [0.0, 1.0], drawing, {}))
        assert gaps_mm(scene, rig, drawing, x).max() < 2e-3


@pytest.mark.parametrize("seed", [1])
def test_the_drawing_of_each_iteration_is_exact(rig: Rig, seed: int) -> None:
    x = any_pose(rig, seed)
    for drawing in rig.drawings:
        buffers = {"m": model_buffer(rig), "d": drawing_buffer(rig, drawing)}
        scene = GltfScene(iterate_gltf(rig, x, drawing, "m", "d"), buffers)
        assert gaps_mm(scene, rig, drawing, x).max() < 2e-3


def test_the_drawing_stays_near_the_skin_in_the_poses_of_a_replay() -> None:
    rig = read_rig(default_rig_path())
    poses = [pose_of_a_patient(rig, seed) for seed in range(4)]
    for drawing in rig.drawings:
        scene = GltfScene(fitted_glb(rig, poses, range(4), drawing, {}))
        for key, x in enumerate(poses):
            gaps = gaps_mm(scene.at_key("registration", key), rig, drawing, x)
            assert np.median(gaps) < 0.3, drawing.name
            assert gaps.max() < 2.5, drawing.name  # where a triangle hangs on more bones than glTF carries


def test_a_ribbon_has_its_width_and_its_lift_at_rest(rig: Rig) -> None:
    for line in lines(rig):
        pairs = line.positions.reshape(-1, 2, 3)
        widths = np.linalg.norm(pairs[:, 0] - pairs[:, 1], axis=1)
        assert np.median(np.abs(widths - WIDTH)) < 0.1 * WIDTH
        assert widths.max() < 1.3 * WIDTH
        lift = np.linalg.norm(line.positions - line.points.positions(rig.template, rig.faces), axis=1)
        np.testing.assert_allclose(lift, LIFT, rtol=1e-9)
        steps = np.linalg.norm(np.diff(pairs.mean(axis=1), axis=0), axis=1)
        assert np.quantile(steps, 0.95) < 1.1 * STEP


def test_a_closed_shape_meets_its_own_beginning_and_an_open_one_does_not(rig: Rig) -> None:
    for line in lines(rig):
        count = len(line.positions) // 2
        joined = any(0 in face and 2 * (count - 1) in face for face in line.faces.tolist())
        assert joined == line.shape.closed
        assert len(line.faces) == 2 * (count if line.shape.closed else count - 1)


def test_ribbons_face_out_of_the_skin(rig: Rig) -> None:
    for line in lines(rig):
        outwards = line.points.positions(vertex_normals(rig.template, rig.faces), rig.faces)
        own = vertex_normals(line.positions, line.faces)
        assert np.quantile(np.einsum("vi,vi->v", own, outwards), 0.02) > 0.5


def test_a_drawing_without_any_line_adds_no_node_and_no_buffer() -> None:
    rig = toy_rig()
    dot = DrawnShape("dot", "Dot", False, "#000000", SurfacePoints(np.array([3]), np.ones((1, 3)) / 3))
    drawing = ModelDrawing("dots", "Dots", (dot,))
    x = random_parameters(rig, np.random.default_rng(0))
    scene = GltfScene(iterate_gltf(rig, x, drawing, "m", "d"), {"m": model_buffer(rig)})
    assert drawing_buffer(rig, drawing) == b""
    assert len(scene.document["buffers"]) == 1
    assert not any(node["name"].startswith("drawing_") for node in scene.nodes)
