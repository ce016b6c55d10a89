"""Closest points against brute force and against shapes whose answer is known."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.geometry.closest_point import ClosestPointSearch, closest_barycentric

Mesh = tuple[np.ndarray, np.ndarray]


def brute_force(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(M,) distance of each point to the nearest of all triangles, none left out."""
    corners = vertices[triangles]
    nearest = np.zeros(len(points))
    for k, point in enumerate(points):
        barycentric = closest_barycentric(np.tile(point, (len(corners), 1)), corners)
        nearest[k] = np.linalg.norm(np.einsum("mc,mcd->md", barycentric, corners) - point, axis=1).min()
    return nearest


def to_edges(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(M,) distance of each point to the nearest edge of its triangle."""
    gaps = []
    for k in range(3):
        start, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        square = (along**2).sum(axis=1)
        share = np.where(square > 0.0, ((points - start) * along).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0)
        gaps.append(np.linalg.norm(start + np.clip(share, 0.0, 1.0)[:, None] * along - points, axis=1))
    return np.asarray(np.min(gaps, axis=0))


def soup_of_all_sizes(rng: np.random.Generator) -> Mesh:
    """Triangles of 0.3 mm to 0.3 m, each size in each place."""
    middles, sizes = rng.uniform(-0.2, 0.2, (1500, 1, 3)), 10.0 ** rng.uniform(-3.5, -0.5, (1500, 1, 1))
    corners = middles + sizes * rng.normal(size=(1500, 3, 3))
    return corners.reshape(-1, 3), np.arange(4500).reshape(-1, 3)


def refined_into_a_corner(rng: np.random.Generator) -> Mesh:
    """A sheet whose triangles shrink from 130 mm to 0.1 mm towards one corner."""
    line = np.concatenate([[0.0], 0.4 * 0.7 ** np.arange(22)[::-1]])
    x, y = np.meshgrid(line, line, indexing="ij")
    at = np.arange(len(line) ** 2).reshape(len(line), len(line))
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    z = 0.02 * rng.normal(size=x.shape) * np.hypot(x, y)
    return np.stack([x, y, z], 2).reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def hole_filled_with_a_fan(_rng: np.random.Generator) -> Mesh:
    """A fine ball whose cap of 60 mm across has been replaced by one fan around a single point."""
    vertices, faces = sphere(0.1, 5)
    kept = faces[vertices[faces].mean(axis=1)[:, 2] < 0.095]
    edges = np.concatenate([kept[:, [0, 1]], kept[:, [1, 2]], kept[:, [2, 0]]])
    both, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    rim = both[count == 1]
    fan = np.column_stack([rim, np.full(len(rim), len(vertices))])
    return np.concatenate([vertices, vertices[np.unique(rim)].mean(axis=0, keepdims=True)]), np.concatenate([kept, fan])


@pytest.mark.parametrize("make", [soup_of_all_sizes, refined_into_a_corner, hole_filled_with_a_fan])
def test_the_search_agrees_with_brute_force_on_triangles_of_all_sizes(
    make: Callable[[np.random.Generator], Mesh], rng: np.random.Generator
) -> None:
    vertices, triangles = make(rng)
    spans = np.linalg.norm(np.diff(vertices[triangles], axis=1), axis=2).max(axis=1)
    assert spans.max() / spans.min() > (8 if make is hole_filled_with_a_fan else 1000)
    low, high = vertices.min(axis=0) - 0.05, vertices.max(axis=0) + 0.05
    corners = vertices[triangles[rng.integers(0, len(triangles), 150)]]
    near = np.einsum("mc,mcd->md", rng.dirichlet(np.ones(3), 150), corners) + 1e-3 * rng.normal(size=(150, 3))
    points = np.concatenate([near, rng.uniform(low, high, (150, 3))])
    found = ClosestPointSearch(vertices, triangles).query(points)
    np.testing.assert_allclose(found.distances, brute_force(vertices, triangles, points), atol=1e-12)
    at = np.einsum("mc,mcd->md", found.barycentric, vertices[triangles[found.faces]])
    np.testing.assert_allclose(at, found.points, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(at - points, axis=1), found.distances, atol=1e-15)
    np.testing.assert_array_less(-1e-12, found.barycentric)


def test_a_point_on_a_large_triangle_among_small_ones_is_on_it() -> None:
    """The nearest centroids all belong to the small triangles, 50 mm away."""
    large = np.array([[-1.0, -0.5, 0.0], [1.0, -0.5, 0.0], [0.0, 1.0, 0.0]])
    fine, faces = plane(0.02, 10)
    vertices = np.concatenate([large, fine + np.array([0.3, 0.0, 0.05])])
    search = ClosestPointSearch(vertices, np.concatenate([[[0, 1, 2]], faces + 3]))
    found = search.query(np.array([[0.3, 0.0, 0.005]]))
    assert found.faces[0] == 0
    np.testing.assert_allclose(found.distances, 0.005, atol=1e-15)


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


@pytest.mark.parametrize("height", [0.0, 1e-16, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5], ids="height {:g}".format)
def test_slivers_down_to_no_height_at_all_project_on_themselves(height: float, rng: np.random.Generator) -> None:
    """A sliver's distance is that to its edges, up to its height; sizes from 0.1 mm to 1 m."""
    sizes = 10.0 ** rng.uniform(-4, 0, (2000, 1))
    corners = sizes[:, None] * rng.normal(size=(2000, 3, 3))
    along = rng.uniform(-1.0, 2.0, (2000, 1))
    corners[:, 2] = (1.0 - along) * corners[:, 0] + along * corners[:, 1] + height * sizes * rng.normal(size=(2000, 3))
    points = corners.mean(axis=1) + sizes * 10.0 ** rng.uniform(-3, 1, (2000, 1)) * rng.normal(size=(2000, 3))
    expected = to_edges(points, corners)
    barycentric = closest_barycentric(points, corners)
    assert (barycentric >= -1e-9).all()
    found = np.linalg.norm(np.einsum("mc,mcd->md", barycentric, corners) - points, axis=1)
    assert (np.abs(found - expected) <= sizes[:, 0] * (10.0 * height + 1e-7)).all()
    for k in range(0, 2000, 40):
        alone = ClosestPointSearch(corners[k], np.array([[0, 1, 2]])).query(points[[k]])
        assert abs(alone.distances[0] - expected[k]) <= sizes[k, 0] * (10.0 * height + 1e-7)


def test_triangles_of_one_line_or_one_point_are_what_they_are() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]])
    search = ClosestPointSearch(vertices, np.array([[1, 2, 0], [0, 0, 1], [3, 3, 3]]))
    found = search.query(np.array([[1.8, 1, 0], [0.2, 1, 0], [5, 5, 6], [-3, 0, 4]]))
    np.testing.assert_allclose(found.points, [[1.8, 0, 0], [0.2, 0, 0], [5, 5, 5], [0, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(found.distances, [1, 1, 1, 5], atol=1e-15)
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1.0, atol=1e-15)


def test_distances_to_a_sphere_are_exact_up_to_its_facets(rng: np.random.Generator) -> None:
    points = rng.normal(size=(500, 3))
    points *= (rng.uniform(0.02, 0.3, 500) / np.linalg.norm(points, axis=1))[:, None]
    found = ClosestPointSearch(*sphere(0.1)).query(points)
    expected = np.abs(np.linalg.norm(points, axis=1) - 0.1)
    np.testing.assert_allclose(found.distances, expected, atol=2e-4)


def test_distances_to_a_plane_are_exact(rng: np.random.Generator) -> None:
    points = rng.uniform(-0.09, 0.09, size=(300, 3))
    found = ClosestPointSearch(*plane()).query(points)
    np.testing.assert_allclose(found.distances, np.abs(points[:, 2]), atol=1e-12)
    np.testing.assert_allclose(found.points[:, :2], points[:, :2], atol=1e-12)


def test_within_reach_the_answer_is_the_same_and_beyond_it_there_is_none(rng: np.random.Generator) -> None:
    search = ClosestPointSearch(*sphere(0.1))
    outward = rng.normal(size=(2500, 3))
    points = outward * (rng.uniform(0.05, 0.2, 2500) / np.linalg.norm(outward, axis=1))[:, None]
    anywhere, near = search.query(points), search.query(points, reach=0.02)
    inside = anywhere.distances <= 0.02
    assert 0.2 < inside.mean() < 0.8
    for name in ("faces", "barycentric", "points", "distances"):
        np.testing.assert_array_equal(getattr(near, name)[inside], getattr(anywhere, name)[inside])
    np.testing.assert_array_equal(near.faces[~inside], -1)
    assert np.isinf(near.distances[~inside]).all()
    np.testing.assert_array_equal(near.points[~inside], points[~inside])


def test_points_that_are_not_finite_find_nothing_and_disturb_no_other() -> None:
    bad = np.array([[np.nan, 0, 0], [0, np.inf, 0], [1e200, 0, 0]])
    found = ClosestPointSearch(*plane(0.2)).query(np.concatenate([bad, [[0.01, 0.02, 0.03]]]))
    np.testing.assert_array_equal(found.faces[:3], -1)
    np.testing.assert_array_equal(found.distances[:3], np.inf)
    np.testing.assert_allclose(found.distances[3], 0.03, atol=1e-15)


def test_a_mesh_without_triangles_and_no_points_at_all_have_answers() -> None:
    nothing = ClosestPointSearch(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)).query(np.zeros((2, 3)))
    np.testing.assert_array_equal(nothing.faces, -1)
    assert len(ClosestPointSearch(*plane(0.2)).query(np.zeros((0, 3))).faces) == 0


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "Vertices must be finite"),
        ([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]], [[0, 1, 2]], "Vertices must be finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "names a vertex that is not there"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -1]], "names a vertex that is not there"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "of shape"),
    ],
)
def test_a_mesh_that_the_library_would_read_amiss_is_refused(vertices: list, triangles: list, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ClosestPointSearch(np.array(vertices, dtype=float), np.array(triangles))


def test_a_search_works_in_the_callers_thread_alone(rng: np.random.Generator) -> None:
    """The library alone would start a thread a core; all work of the process must be this thread's."""
    search, points = ClosestPointSearch(*sphere(0.1, 5)), rng.normal(size=(20_000, 3))  # it starts them from 1,000 on
    everyone, here = time.process_time(), time.thread_time()
    search.query(points)
    here = time.thread_time() - here
    assert here > 0.9 * (time.process_time() - everyone)


@pytest.mark.parametrize("make", [soup_of_all_sizes, refined_into_a_corner, hole_filled_with_a_fan])
def test_distances_alone_are_those_of_the_whole_answer(make: Callable[..., Mesh], rng: np.random.Generator) -> None:
    vertices, triangles = make(rng)
    search, points = ClosestPointSearch(vertices, triangles), rng.uniform(-0.3, 0.3, (2500, 3))
    points[7] = np.nan
    whole, (faces, distances) = search.query(points), search.distances(points)
    np.testing.assert_allclose(distances, whole.distances, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(faces, whole.faces)
    assert (faces[7], distances[7]) == (-1, np.inf)
    assert ClosestPointSearch(vertices, triangles[:0]).distances(points)[0].tolist() == [-1] * len(points)
