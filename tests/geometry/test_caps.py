"""Openings of known surfaces, closed."""

import numpy as np
import pytest
import trimesh
from helpers.surfaces import sphere

from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.caps import cap_of, closed
from breastrig.gltf.read_rig import default_rig_path, read_rig


def smallest_angle(vertices: np.ndarray, faces: np.ndarray) -> float:
    return float(np.degrees(trimesh.Trimesh(vertices, faces, process=False).face_angles.min()))


@pytest.mark.parametrize("heights", [(-0.05,), (-0.06, 0.03)])
def test_a_cut_sphere_becomes_watertight_and_keeps_its_volume(heights: tuple[float, ...]) -> None:
    vertices, faces = sphere(0.1, 4)
    centres = vertices[faces].mean(axis=1)[:, 2]
    kept = centres > heights[0]
    if len(heights) == 2:
        kept &= centres < heights[1]
    cut, triangles = vertices, faces[kept]
    result = closed(cut, triangles)
    mesh = trimesh.Trimesh(result.vertices, result.faces, process=False)
    assert len(result.caps) == len(heights)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    a, b = heights[0], heights[1] if len(heights) == 2 else 0.1
    assert mesh.volume == pytest.approx(np.pi * (0.01 * (b - a) - (b**3 - a**3) / 3.0), rel=0.03)
    assert (result.faces[: len(triangles)] == triangles).all()
    assert (result.vertices[: len(cut)] == cut).all()


def test_a_round_rim_gets_well_shaped_triangles_as_large_as_its_edges() -> None:
    turn = 2.0 * np.pi * np.arange(40) / 40
    rim = np.stack([0.15 * np.cos(turn), 0.10 * np.sin(turn), 0.005 * np.cos(2 * turn)], axis=1)
    inner, triangles = cap_of(rim)
    points = np.concatenate([rim, inner])
    assert smallest_angle(points, triangles) > 24.0
    edges = trimesh.Trimesh(points, triangles, process=False).edges_unique_length
    rim_edge = np.median(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1))
    assert edges.max() < 2.0 * rim_edge
    assert edges.min() > 0.4 * rim_edge
    assert abs(inner[:, 2]).max() <= 0.005
    assert (
        np.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])[
            :, 2
        ].max()
        < 0.0
    )  # the border runs counter-clockwise, so the surface lies above


def test_a_rim_that_is_not_convex_is_filled_inside_only() -> None:
    turn = 2.0 * np.pi * np.arange(60) / 60
    radius = 0.1 * (1.0 + 0.35 * np.cos(3 * turn))
    rim = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(60)], axis=1)
    inner, triangles = cap_of(rim)
    area = trimesh.Trimesh(np.concatenate([rim, inner]), triangles, process=False).area
    x, y = rim[:, 0], rim[:, 1]
    assert area == pytest.approx(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)), rel=1e-9)


def test_a_rim_that_folds_over_itself_is_closed_all_the_same() -> None:
    turn = 2.0 * np.pi * np.arange(24) / 24
    rim = np.stack([0.1 * np.cos(turn), 0.02 * np.sin(2 * turn), 0.05 * np.sin(turn)], axis=1)
    inner, triangles = cap_of(rim)
    assert len(boundary_loops(triangles)) == 1
    assert triangles.max() < len(rim) + len(inner)


def test_the_model_is_closed_with_four_caps() -> None:
    rig = read_rig(default_rig_path())
    result = closed(np.array(rig.template), rig.faces)
    mesh = trimesh.Trimesh(result.vertices, result.faces, process=False)
    assert len(result.caps) == 4
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert 0.01 < mesh.volume < 0.05
    for cap in result.caps:
        assert smallest_angle(result.vertices, result.faces[cap]) > 24.0
