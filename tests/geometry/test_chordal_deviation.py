import numpy as np
import pytest
import trimesh

from breastrig.geometry.normals import face_areas, vertex_normals
from breastrig.geometry.surface_points import ChordalDeviation

RADIUS = 0.06  # m


def of(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V,) m"""
    return ChordalDeviation(vertices, faces)(vertices, vertex_normals(vertices, faces))


def integral(values: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> float:
    """Over the triangles, each vertex with a third of those around it."""
    return float((face_areas(vertices, faces)[:, None] / 3.0 * values[faces]).sum())


def gap_to_the_sphere(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Integral over the flat triangles, by many samples."""
    fine, pieces = vertices, faces
    for _ in range(4):
        fine, pieces = trimesh.remesh.subdivide(fine, pieces)
    fine, pieces = np.asarray(fine), np.asarray(pieces)
    return integral(RADIUS - np.linalg.norm(fine, axis=1), fine, pieces)


@pytest.mark.parametrize("inwards", [False, True])
def test_on_a_sphere_it_adds_up_to_the_gap_between_triangles_and_surface(inwards: bool) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=RADIUS)
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    found = integral(of(vertices, faces[:, ::-1] if inwards else faces), vertices, faces)
    assert found == pytest.approx((-1.0 if inwards else 1.0) * gap_to_the_sphere(vertices, faces), rel=0.01)


def test_it_does_not_depend_on_where_the_mesh_lies_and_how_it_is_turned() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=RADIUS)
    vertices, faces = np.array(ball.vertices) * [1.0, 2.0, 0.5], np.array(ball.faces)
    turn = trimesh.transformations.random_rotation_matrix(np.random.default_rng(0).random(3))[:3, :3]
    np.testing.assert_allclose(of(vertices @ turn.T + [1.0, -2.0, 3.0], faces), of(vertices, faces), atol=1e-13)


def test_a_plane_and_a_vertex_without_triangle_have_none() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]])
    np.testing.assert_allclose(of(vertices, np.array([[0, 1, 2], [0, 2, 3]])), 0.0, atol=1e-15)
