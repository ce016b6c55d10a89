"""Three ways to match, one answer; and what is dismissed."""

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget

METHODS = ["rays", "tree", "nearest_vertex"]


@pytest.fixture(scope="module")
def ball() -> ScanTarget:
    return ScanTarget(*sphere(0.1, 5))


def around(rng: np.random.Generator, radius: float) -> tuple[np.ndarray, np.ndarray]:
    normals = rng.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return radius * normals, normals


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("radius", [0.09, 0.1, 0.11])
def test_points_off_a_sphere_find_the_point_below_them(
    method: str, radius: float, ball: ScanTarget, rng: np.random.Generator
) -> None:
    points, normals = around(rng, radius)
    found = match(ball, points, normals, MatchRules(method))
    np.testing.assert_array_equal(found.vertices, np.arange(300))
    np.testing.assert_allclose(found.distances, abs(radius - 0.1), atol=1e-4)
    np.testing.assert_allclose(found.points, 0.1 * normals, atol=2e-3)
    assert (np.einsum("mi,mi->m", found.normals, normals) > 0.999).all()


@pytest.mark.parametrize("method", METHODS)
def test_normals_that_disagree_are_dismissed(method: str, ball: ScanTarget, rng: np.random.Generator) -> None:
    points, normals = around(rng, 0.1)
    assert len(match(ball, points, -normals, MatchRules(method)).vertices) == 0


@pytest.mark.parametrize("method", METHODS)
def test_what_is_too_far_is_dismissed(method: str, ball: ScanTarget, rng: np.random.Generator) -> None:
    points, normals = around(rng, 0.13)
    assert len(match(ball, points, normals, MatchRules(method, max_distance=0.02)).vertices) == 0


@pytest.mark.parametrize("method", ["tree", "nearest_vertex"])
def test_a_point_beside_the_scan_does_not_stick_to_its_border(method: str) -> None:
    target = ScanTarget(*plane(0.2))
    points = np.array([[0.12, 0.0, 0.001], [0.0, 0.0, 0.001]])
    normals = np.array([[0.0, 0.0, 1.0]] * 2)
    assert match(target, points, normals, MatchRules(method)).vertices.tolist() == [1]
    kept = match(target, points, normals, MatchRules(method, reject_border=False))
    assert kept.vertices.tolist() == [0, 1]


def test_without_rays_the_tree_answers_the_same(ball: ScanTarget, rng: np.random.Generator) -> None:
    points, normals = around(rng, 0.105)
    trees_only = ScanTarget(ball.vertices, ball.faces, use_rays=False)
    assert trees_only.rays is None
    by_rays, by_tree = (match(target, points, normals, MatchRules("rays")) for target in (ball, trees_only))
    np.testing.assert_allclose(by_rays.points, by_tree.points, atol=1e-4)


def test_the_surface_inside_a_triangle_is_mixed_from_its_corners(rng: np.random.Generator) -> None:
    target = ScanTarget(*plane(0.2))
    faces, weights = rng.integers(0, len(target.faces), 50), rng.dirichlet(np.ones(3), 50)
    points, normals, border = target.surface_at(faces, weights)
    corners = target.faces[faces]
    np.testing.assert_allclose(points, np.einsum("mc,mcd->md", weights, target.vertices[corners]), atol=1e-15)
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (50, 1)), atol=1e-12)
    np.testing.assert_allclose(border, (weights * target.on_border[corners]).sum(axis=1), atol=1e-12)
