"""The drawing in a glTF lies on the skin of the posed model, as the exact surface points do."""

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.random_pose import random_parameters
from helpers.toy_rig import toy_rig

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.iterate import drawing_buffer, iterate_gltf, model_buffer
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.ribbon import LIFT, STEP, WIDTH, ribbon
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig
from breastrig.rig.skinning import pose


def drawn(rig: Rig, drawing: ModelDrawing, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ribbon vertices in a random pose: as drawn, as the exact lifted surface points, and the posed mesh."""
    x = random_parameters(rig, np.random.default_rng(seed), turn=0.2, move=0.01, scale=0.15, shape=0.5)
    text = iterate_gltf(rig, x, drawing, "m", "d")
    scene = GltfScene(text, {"m": model_buffer(rig), "d": drawing_buffer(rig, drawing)})
    mesh = pose(rig, x)
    normals = vertex_normals(mesh, rig.faces)
    search = ClosestPointSearch(rig.template, rig.faces)
    ribbons = [ribbon(rig, search, shape) for shape in drawing.shapes]
    exact = np.concatenate(
        [
            line.points.positions(mesh, rig.faces) + LIFT * line.points.positions(normals, rig.faces)
            for line in ribbons
            if line is not None
        ]
    )
    return scene.positions(f"drawing_{drawing.name}"), exact, mesh


@pytest.mark.parametrize("seed", range(5))
def test_the_drawing_is_within_0_3_mm_of_the_exact_surface_points_of_the_torso(seed: int) -> None:
    rig = read_rig(default_rig_path())
    for drawing in rig.drawings:
        found, exact, _ = drawn(rig, drawing, seed)
        gaps = 1e3 * np.linalg.norm(found - exact, axis=1)
        assert gaps.max() < 0.3, f"{drawing.name}: {gaps.max():.3f} mm"


def test_the_drawing_lies_on_the_coarse_toy_rig_too() -> None:
    rig = toy_rig()  # triangles of 80 mm: interpolation is coarser than on the torso
    found, exact, _ = drawn(rig, rig.drawings[0], 1)
    assert np.linalg.norm(found - exact, axis=1).max() < 2e-3


def test_a_ribbon_has_its_width_and_its_lift_at_rest() -> None:
    rig = toy_rig()
    line = ribbon(rig, ClosestPointSearch(rig.template, rig.faces), rig.drawings[0].shapes[0])
    assert line is not None
    pairs = line.positions.reshape(-1, 2, 3)
    widths = np.linalg.norm(pairs[:, 0] - pairs[:, 1], axis=1)
    assert np.abs(widths - WIDTH).max() < 0.15 * WIDTH
    lift = np.linalg.norm(line.positions - line.points.positions(rig.template, rig.faces), axis=1)
    np.testing.assert_allclose(lift, LIFT, rtol=1e-9)
    assert np.linalg.norm(np.diff(pairs.mean(axis=1), axis=0), axis=1).max() < 1.1 * STEP


def test_a_closed_shape_meets_its_own_beginning_and_an_open_one_does_not() -> None:
    rig = toy_rig()
    search = ClosestPointSearch(rig.template, rig.faces)
    for shape in rig.drawings[0].shapes:
        line = ribbon(rig, search, shape)
        assert line is not None
        count = len(line.positions) // 2
        joined = any(0 in face and 2 * (count - 1) in face for face in line.faces.tolist())
        assert joined == shape.closed
        assert len(line.faces) == 2 * (count if shape.closed else count - 1)


def test_ribbons_face_out_of_the_skin() -> None:
    rig = toy_rig()
    for shape in rig.drawings[0].shapes:
        line = ribbon(rig, ClosestPointSearch(rig.template, rig.faces), shape)
        assert line is not None
        outwards = line.points.positions(vertex_normals(rig.template, rig.faces), rig.faces)
        own = vertex_normals(line.positions, line.faces)
        assert np.einsum("vi,vi->v", own, outwards).min() > 0.5


def test_a_drawing_without_any_line_adds_no_node_and_no_buffer() -> None:
    rig = toy_rig()
    dot = DrawnShape("dot", "Dot", False, "#000000", SurfacePoints(np.array([3]), np.ones((1, 3)) / 3))
    drawing = ModelDrawing("dots", "Dots", (dot,))
    x = random_parameters(rig, np.random.default_rng(0))
    scene = GltfScene(iterate_gltf(rig, x, drawing, "m", "d"), {"m": model_buffer(rig)})
    assert drawing_buffer(rig, drawing) == b""
    assert len(scene.document["buffers"]) == 1
    assert not any(node["name"].startswith("drawing_") for node in scene.nodes)
