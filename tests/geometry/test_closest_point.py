"""Closest points against brute force and against shapes whose answer is known."""

import numpy as np
from helpers.surfaces import plane, sphere

from breastrig.geometry.closest_point import ClosestPointSearch, closest_barycentric


def test_every_region_of_a_triangle_projects_right(rng: np.random.Generator) -> None:
    corners = rng.normal(size=(200, 3, 3))
    points = 3 * rng.normal(size=(200, 3))
    barycentric = closest_barycentric(points, corners)
    assert (barycentric >= -1e-12).all()
    np.testing.assert_allclose(barycentric.sum(axis=1), 1.0, atol=1e-12)
    found = np.linalg.norm(np.einsum("mc,mcd->md", barycentric, corners) - points, axis=1)
    grid = np.linspace(0, 1, 101)
    s, t = (g.ravel() for g in np.meshgrid(grid, grid))
    s, t = s[s + t <= 1], t[s + t <= 1]
    samples = np.stack([1 - s - t, s, t], axis=1) @ corners  # (200, K, 3)
    nearest = np.linalg.norm(samples - points[:, None], axis=2).min(axis=1)
    assert (found <= nearest + 1e-12).all()
    assert (nearest - found < 0.1).all()


def test_triangles_without_area_still_answer_with_a_finite_point() -> None:
    corners = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 0, 0]], [[0.0, 0, 0], [0, 0, 0], [0, 0, 0]]])
    barycentric = closest_barycentric(np.array([[2.0, 1, 0], [1.0, 1, 1]]), corners)
    assert np.isfinite(barycentric).all()
    np.testing.assert_allclose(np.einsum("mc,mcd->md", barycentric, corners), [[1, 0, 0], [0, 0, 0]], atol=1e-12)


def test_distances_to_a_sphere_are_exact_up_to_its_facets(rng: np.random.Generator) -> None:
    points = rng.normal(size=(500, 3))
    points *= (rng.uniform(0.02, 0.3, 500) / np.linalg.norm(points, axis=1))[:, None]
    found = ClosestPointSearch(*sphere(0.1)).query(points)
    expected = np.abs(np.linalg.norm(points, axis=1) - 0.1)
    np.testing.assert_allclose(found.distances, expected, atol=2e-4)


def test_distances_to_a_plane_are_exact(rng: np.random.Generator) -> None:
    points = rng.uniform(-0.09, 0.09, size=(300, 3))
    found = ClosestPointSearch(*plane()).query(points, candidates=8)
    np.testing.assert_allclose(found.distances, np.abs(points[:, 2]), atol=1e-12)
    np.testing.assert_allclose(found.points[:, :2], points[:, :2], atol=1e-12)


def test_fewer_candidates_within_reach_than_asked_for_are_enough(rng: np.random.Generator) -> None:
    search = ClosestPointSearch(*sphere(0.1))
    points = 0.1 * (outward := rng.normal(size=(200, 3))) / np.linalg.norm(outward, axis=1, keepdims=True)
    all_of_them, few = search.query(points, candidates=8), search.query(points, 8, search.largest_reach)
    np.testing.assert_array_equal(few.faces >= 0, True)
    assert (few.distances <= all_of_them.distances + 1e-4).all()
    far = search.query(2.0 * points, 8, search.largest_reach)
    np.testing.assert_array_equal(far.faces, -1)
    assert np.isinf(far.distances).all()
    np.testing.assert_array_equal(far.points, 2.0 * points)
