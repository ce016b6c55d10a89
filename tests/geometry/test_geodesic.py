"""Where the answer is known: a plane, a sphere, a folded plane, parts that are not connected."""

import numpy as np
import pytest
import trimesh

from breastrig.core.errors import BadDrawing
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.half_edges import split_places
from breastrig.geometry.polyline import length
from breastrig.geometry.surface_points import SurfacePoints

INSIDE = np.array([0.2, 0.5, 0.3])


def plane(cells: int = 12, size: float = 0.24) -> tuple[np.ndarray, np.ndarray]:
    """A square of ragged triangles in z = 0."""
    x, y = np.meshgrid(*2 * [np.linspace(-size / 2, size / 2, cells + 1)], indexing="ij")
    inner = np.zeros_like(x, dtype=bool)
    inner[1:-1, 1:-1] = True
    shake = np.random.default_rng(5).uniform(-0.3, 0.3, (2, *x.shape)) * size / cells * inner
    vertices = np.stack([x + shake[0], y + shake[1], 0 * x], axis=2).reshape(-1, 3)
    at = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def one(face: int, barycentric: np.ndarray = INSIDE) -> SurfacePoints:
    return SurfacePoints(np.array([face]), barycentric[None])


@pytest.mark.parametrize(
    "barycentric", [INSIDE, np.array([0.4, 0.6, 0.0]), np.array([0.0, 0.0, 1.0])], ids=["inside", "edge", "corner"]
)
def test_on_a_plane_it_is_the_straight_distance(barycentric: np.ndarray) -> None:
    vertices, faces = plane()
    source = barycentric @ vertices[faces[100]]
    found = Geodesics(vertices, faces).distances(100, barycentric)
    np.testing.assert_allclose(found, np.linalg.norm(vertices - source, axis=1), atol=1e-9)


def test_beyond_the_reach_it_is_infinite() -> None:
    vertices, faces = plane()
    straight = np.linalg.norm(vertices - INSIDE @ vertices[faces[100]], axis=1)
    found = Geodesics(vertices, faces).distances(100, INSIDE, reach=0.05)
    np.testing.assert_allclose(found[straight < 0.05], straight[straight < 0.05], atol=1e-9)
    assert np.isinf(found[straight > 0.05]).all()


def test_a_path_on_a_plane_is_straight() -> None:
    vertices, faces = plane()
    for goal in (one(7), one(270, np.array([0.5, 0.0, 0.5])), one(100, np.array([0.6, 0.1, 0.3]))):
        way = Geodesics(vertices, faces).path(one(100), goal)
        ends = np.array([INSIDE @ vertices[faces[100]], goal.positions(vertices, faces)[0]])
        np.testing.assert_allclose(way[[0, -1]], ends, atol=2e-6)
        assert length(way) == pytest.approx(np.linalg.norm(ends[1] - ends[0]), abs=1e-8)


def test_a_path_to_itself_has_no_length() -> None:
    vertices, faces = plane()
    assert length(Geodesics(vertices, faces).path(one(100), one(100))) == pytest.approx(0.0, abs=2e-6)


def test_around_a_fold_the_tape_bends() -> None:
    """A plane folded by a right angle is still flat for who walks on it."""
    vertices, faces = plane(cells=12)
    flat = vertices.copy()
    flat[6 * 13 : 7 * 13, 0] = 0.0
    vertices = np.where(flat[:, [0]] > 0.0, flat[:, [2, 1, 0]] * [1, 1, -1], flat)
    source = flat[faces[20]].mean(axis=0)
    found = Geodesics(vertices, faces).distances(20, np.full(3, 1 / 3))
    np.testing.assert_allclose(found, np.linalg.norm(flat - source, axis=1), atol=1e-9)


def test_on_a_sphere_it_is_the_great_circle() -> None:
    """Chords are shorter than arcs, by (edge / radius)² / 12 on average and at most twice that here."""
    radius = 0.1
    ball = trimesh.creation.icosphere(4, radius)
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    edge = float(ball.edges_unique_length.max())
    source = INSIDE @ vertices[faces[50]]
    arcs = radius * np.arccos(np.clip(vertices @ source / (radius * np.linalg.norm(source)), -1.0, 1.0))
    found = Geodesics(vertices, faces).distances(50, INSIDE)
    assert np.abs(found - arcs).max() < 1e-4 + (edge / radius) ** 2 / 6 * np.pi * radius
    way = Geodesics(vertices, faces).path(one(50), one(3000))
    assert length(way) == pytest.approx(found[faces[3000]] @ INSIDE, abs=edge / 2)
    assert ClosestPointSearch(vertices, faces).query(way).distances.max() < 1e-9


def test_a_circle_on_a_plane_is_a_circle() -> None:
    vertices, faces = plane()
    source = INSIDE @ vertices[faces[100]]
    for radius in (0.003, 0.02, 0.05):
        rim = Geodesics(vertices, faces).circle(100, INSIDE, radius)
        off = np.abs(np.linalg.norm(rim - source, axis=1) - radius)
        assert off.max() < 1e-7
        angles = np.unwrap(np.arctan2(*(rim - source)[:, [1, 0]].T))
        assert (np.diff(angles) > 0.0).all()  # counter-clockwise, once around
        assert angles[-1] - angles[0] == pytest.approx(2 * np.pi, abs=0.2)
        assert length(rim, closed=True) == pytest.approx(2 * np.pi * radius, rel=5e-3)  # chords


def test_a_circle_far_smaller_than_the_triangles_splits_only_those_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = plane()
    many: list[int] = []

    def counted(places: np.ndarray) -> np.ndarray:
        many.append(len(places))
        return split_places(places)

    monkeypatch.setattr("breastrig.geometry.geodesic.split_places", counted)
    rim = Geodesics(vertices, faces).circle(100, INSIDE, 1e-4)
    assert np.abs(np.linalg.norm(rim - INSIDE @ vertices[faces[100]], axis=1) - 1e-4).max() < 1e-9
    assert len(many) > 8
    assert max(many) < 300  # 4 ** 9 times as many as at first, when all of them are


def test_a_circle_on_a_sphere() -> None:
    radius = 0.1
    ball = trimesh.creation.icosphere(4, radius)
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    source = INSIDE @ vertices[faces[50]]
    rim = Geodesics(vertices, faces).circle(50, INSIDE, 0.06)
    arcs = radius * np.arccos(rim @ source / np.linalg.norm(rim, axis=1) / np.linalg.norm(source))
    np.testing.assert_allclose(arcs, 0.06, atol=2e-4)
    assert ClosestPointSearch(vertices, faces).query(rim).distances.max() < 1e-12


def test_a_circle_that_meets_the_end_of_the_surface_is_refused() -> None:
    with pytest.raises(BadDrawing, match="A circle of 300 mm on the skin does not close here"):
        Geodesics(*plane()).circle(100, INSIDE, 0.3)


def test_a_circle_that_meets_the_end_on_one_side_is_refused() -> None:
    with pytest.raises(BadDrawing, match="the surface ends before"):
        Geodesics(*plane()).circle(0, INSIDE, 0.05)


def test_unconnected_parts() -> None:
    vertices, faces = plane(4)
    both = np.concatenate([vertices, vertices + np.array([0.0, 0.0, 0.001]), [[9.0, 9.0, 9.0]]])
    geodesics = Geodesics(both, np.concatenate([faces, faces + len(vertices)]))
    found = geodesics.distances(5, INSIDE)
    np.testing.assert_array_equal(np.isinf(found), np.arange(len(both)) >= len(vertices))
    with pytest.raises(BadDrawing, match="not connected"):
        geodesics.path(one(5), one(len(faces) + 5))
    rim = geodesics.circle(5, INSIDE, 0.02)
    np.testing.assert_array_equal(rim[:, 2], 0.0)  # the sheet one millimetre above is another one
