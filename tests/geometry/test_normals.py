import numpy as np
import pytest

from breastrig.geometry.normals import VertexNormals, face_areas, face_normals, vertex_normals

TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
OUTWARD = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_face_normals_point_out_of_a_counter_clockwise_solid() -> None:
    normals = face_normals(TETRAHEDRON, OUTWARD)
    np.testing.assert_allclose(normals[:3], [[0, 0, -1], [0, -1, 0], [-1, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(normals[3], np.full(3, 3**-0.5), atol=1e-15)


def test_areas_add_up_to_the_surface() -> None:
    np.testing.assert_allclose(face_areas(TETRAHEDRON, OUTWARD), [0.5, 0.5, 0.5, 3**0.5 / 2])


def test_vertex_normals_are_weighted_by_area() -> None:
    crosses = np.array([[0, 0, -1.0], [0, -1, 0], [-1, 0, 0], [1, 1, 1]])
    expected = np.array([crosses[[0, 1, 2]].sum(0), crosses[[0, 1, 3]].sum(0), crosses[[0, 2, 3]].sum(0)])
    found = vertex_normals(TETRAHEDRON, OUTWARD)
    np.testing.assert_allclose(found[:3], expected / np.linalg.norm(expected, axis=1)[:, None], atol=1e-15)


def test_the_normal_of_the_corner_of_a_sheared_solid_turns_with_the_solid() -> None:
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    normals = VertexNormals(OUTWARD, 4)
    np.testing.assert_allclose(normals(TETRAHEDRON @ turn.T), normals(TETRAHEDRON) @ turn.T, atol=1e-14)


@pytest.mark.parametrize("lonely", [5, 6])
def test_a_vertex_without_triangle_gets_a_unit_vector_all_the_same(lonely: int) -> None:
    normals = vertex_normals(np.concatenate([TETRAHEDRON, np.zeros((lonely - 4, 3))]), OUTWARD)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
