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


def test_what_rays_miss_gets_the_exact_closest_point(rng: np.random.Generator) -> None:
    """A fan of long triangles closes the ball's cap; normals along the skin make every ray miss."""
    vertices, faces = sphere(0.1, 4)
    kept = faces[vertices[faces].mean(axis=1)[:, 2] < 0.085]
    edges = np.sort(kept[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    pairs, count = np.unique(edges, axis=0, return_counts=True)
    rim = pairs[count == 1]
    fan = np.column_stack([rim, np.full(len(rim), len(vertices))])
    height = vertices[rim][..., 2].min()
    vertices[np.unique(rim), 2] = height  # the fan is flat
    target = ScanTarget(np.concatenate([vertices, [[0.0, 0.0, height]]]), np.concatenate([kept, fan]))
    turns, radii = rng.uniform(0.0, 2.0 * np.pi, 200), rng.uniform(0.005, 0.035, 200)
    points = np.column_stack([radii * np.cos(turns), radii * np.sin(turns), np.full(200, height + 0.004)])
    normals = np.tile([1.0, 0.0, 0.0], (200, 1))
    found = match(target, points, normals, MatchRules("rays", 0.005, max_angle=np.pi, reject_border=False))
    np.testing.assert_array_equal(found.vertices, np.arange(200))
    np.testing.assert_allclose(found.distances, 0.004, atol=1e-12)


def test_only_what_is_certainly_too_far_is_ruled_out(rng: np.random.Generator) -> None:
    """Also on triangles that are larger than the reach."""
    soup = rng.uniform(-0.2, 0.2, (300, 1, 3)) + 10.0 ** rng.uniform(-3, -1, (300, 1, 1)) * rng.normal(size=(300, 3, 3))
    target = ScanTarget(soup.reshape(-1, 3), np.arange(900).reshape(-1, 3))
    points = rng.uniform(-1.0, 1.0, (2000, 3))
    distances = target.search.query(points).distances
    for reach in (0.003, 0.03, 0.3):
        ruled_out = np.setdiff1d(np.arange(2000), target.may_be_matched(points, reach, reject_border=False))
        assert len(ruled_out)
        assert (distances[ruled_out] > reach).all()


def test_what_lies_beyond_the_border_is_ruled_out_and_nothing_above_the_inner_scan(rng: np.random.Generator) -> None:
    target = ScanTarget(*plane(0.2))
    low, high = target.vertices.min(axis=0)[:2], target.vertices.max(axis=0)[:2]
    points = np.column_stack([rng.uniform(1.3 * low, 1.3 * high, (2000, 2)), rng.uniform(-0.02, 0.02, 2000)])
    kept = target.may_be_matched(points, 0.1, reject_border=True)
    edge = np.linalg.norm(target.vertices[target.faces[0, 0]] - target.vertices[target.faces[0, 1]])
    inside = ((points[:, :2] > low + edge) & (points[:, :2] < high - edge)).all(axis=1)
    assert set(np.flatnonzero(inside)) <= set(kept)
    far_out = (np.maximum(low - points[:, :2], points[:, :2] - high) > 0.02).any(axis=1)
    assert not set(np.flatnonzero(far_out)) & set(kept)


def test_the_surface_inside_a_triangle_is_mixed_from_its_corners(rng: np.random.Generator) -> None:
    target = ScanTarget(*plane(0.2))
    faces, weights = rng.integers(0, len(target.faces), 50), rng.dirichlet(np.ones(3), 50)
    points, normals, border = target.surface_at(faces, weights)
    corners = target.faces[faces]
    np.testing.assert_allclose(points, np.einsum("mc,mcd->md", weights, target.vertices[corners]), atol=1e-15)
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (50, 1)), atol=1e-12)
    np.testing.assert_allclose(border, (weights * target.on_border[corners]).sum(axis=1), atol=1e-12)
