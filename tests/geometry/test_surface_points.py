"""Points on a mesh as triangle and weights: where they are, and which way is out."""

import numpy as np

from breastrig.geometry.normals import unit_vectors
from breastrig.geometry.surface_points import SurfacePoints

CORNERS = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
TRIANGLE = np.array([[0, 1, 2]])
POINTS = SurfacePoints(np.zeros(2, np.int64), np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.5]]))


def test_positions_are_between_the_corners() -> None:
    np.testing.assert_allclose(POINTS.positions(CORNERS, TRIANGLE), [[0.0, 0.0, 0.0], [1.5, 1.5, 0.0]])


def test_directions_are_between_the_corners_normals_and_of_length_one() -> None:
    normals = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = POINTS.directions(normals, TRIANGLE)
    np.testing.assert_allclose(found, [[0.0, 0.0, 1.0], [np.sqrt(0.5), np.sqrt(0.5), 0.0]])


def test_a_vector_without_a_direction_stays_zero(rng: np.random.Generator) -> None:
    vectors = rng.normal(size=(5, 3))
    vectors[2] = 0.0
    found = unit_vectors(vectors)
    np.testing.assert_array_equal(found[2], 0.0)
    np.testing.assert_allclose(np.linalg.norm(np.delete(found, 2, axis=0), axis=1), 1.0)
    np.testing.assert_allclose(np.cross(found, vectors), 0.0, atol=1e-12)
