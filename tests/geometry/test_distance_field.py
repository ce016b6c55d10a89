"""Distances and paths of many points at once, on meshes where that is easy, hard, and known."""

import numpy as np
import pytest
import trimesh
from helpers.exact_geodesics import exact_circle, exact_distances
from helpers.surfaces import plane

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.fields.distance_field import DistanceFields
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.half_edges import HalfEdges
from breastrig.geometry.polyline import length
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import compact

Mesh = tuple[np.ndarray, np.ndarray]


def ball(subdivisions: int = 3) -> Mesh:
    made = trimesh.creation.icosphere(subdivisions, 0.1)
    return np.array(made.vertices), np.array(made.faces, dtype=np.int64)


def crumpled(rng: np.random.Generator) -> Mesh:
    vertices, faces = ball()
    return vertices * rng.uniform(0.8, 1.2, (len(vertices), 1)), faces


def full_of_holes(rng: np.random.Generator) -> Mesh:
    """A hole around each of many vertices that are no neighbours' neighbours: most paths bend at some."""
    vertices, faces = ball(4)
    middles: list[int] = []
    for vertex in rng.permutation(len(vertices)):
        if all(np.linalg.norm(vertices[vertex] - vertices[other]) > 0.025 for other in middles):
            middles.append(int(vertex))
    assert len(middles) > 100
    return compact(vertices, faces[~np.isin(faces, middles).any(axis=1)])


def box(_rng: np.random.Generator) -> Mesh:
    """Many paths are equally long, and bend over edges or not at all."""
    made = trimesh.creation.box((0.1, 0.2, 0.3)).subdivide().subdivide()
    return np.array(made.vertices), np.array(made.faces, dtype=np.int64)


def needles(rng: np.random.Generator) -> Mesh:
    vertices, faces = ball()
    return vertices * [1.0, 1.0, 40.0] + 1e-4 * rng.normal(size=vertices.shape), faces


MESHES = [crumpled, full_of_holes, box, needles, lambda rng: plane(0.2, 12)]


def somewhere(faces: np.ndarray, count: int, rng: np.random.Generator) -> SurfacePoints:
    """Corners, places on edges and inside of triangles in turn."""
    shares = rng.dirichlet(np.ones(3), count)
    shares[::3] = np.eye(3)[rng.integers(0, 3, len(shares[::3]))]
    shares[1::3, rng.integers(0, 3)] = 0.0
    return SurfacePoints(rng.integers(0, len(faces), count), shares / shares.sum(axis=1, keepdims=True))


def one(points: SurfacePoints, k: int) -> SurfacePoints:
    return SurfacePoints(points.faces[[k]], points.barycentric[[k]])


@pytest.mark.parametrize("make", MESHES)
def test_distances_are_those_of_another_implementation(make, rng: np.random.Generator) -> None:
    vertices, faces = make(rng)
    sources = somewhere(faces, 6, rng)
    fields = DistanceFields(HalfEdges(vertices, faces), sources, np.full(6, np.inf))
    for k in range(6):
        exact = exact_distances(vertices, faces, int(sources.faces[k]), sources.barycentric[k])
        used = np.unique(faces)
        np.testing.assert_allclose(fields.to_vertices(k)[used], exact[used], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("make", MESHES)
def test_a_path_lies_on_the_mesh_and_is_as_long_as_the_exact_distance(make, rng: np.random.Generator) -> None:
    vertices, faces = make(rng)
    sources, goals = somewhere(faces, 3, rng), somewhere(faces, 10, rng)
    mesh, checked = HalfEdges(vertices, faces), 0
    fields = DistanceFields(mesh, sources, np.full(3, np.inf))
    for k in range(3):
        far = fields.at(k, goals)
        for goal in np.flatnonzero(np.isfinite(far)):
            way = fields.path(k, one(goals, int(goal)))
            np.testing.assert_allclose(way[0], one(sources, k).positions(vertices, faces)[0], atol=1e-12)
            np.testing.assert_allclose(way[-1], one(goals, int(goal)).positions(vertices, faces)[0], atol=1e-12)
            assert length(way) == pytest.approx(far[goal], abs=1e-11)
            assert lies_on(vertices, faces, way)
            back = Geodesics(vertices, faces).path(one(goals, int(goal)), one(sources, k)) if goal < 2 else way
            assert length(back) == pytest.approx(far[goal], abs=1e-9)
            checked += 1
    assert checked > 20


def test_measured_from_several_places_at_once_it_is_the_same(rng: np.random.Generator) -> None:
    vertices, faces = crumpled(rng)
    mesh, sources = HalfEdges(vertices, faces), somewhere(faces, 5, rng)
    together = DistanceFields(mesh, sources, np.array([0.03, 0.05, 0.08, 0.2, np.inf]))
    for k in range(5):
        alone = DistanceFields(mesh, one(sources, k), np.array([np.inf])).to_vertices(0)
        near = alone <= together.reach[k]
        np.testing.assert_array_equal(together.to_vertices(k)[near], alone[near])
        assert (together.to_vertices(k)[~near] > together.reach[k]).all()


def test_paths_looked_for_together_are_those_looked_for_alone(rng: np.random.Generator) -> None:
    vertices, faces = crumpled(rng)
    a, b = somewhere(faces, 8, rng), somewhere(faces, 8, rng)
    together, kept = Geodesics(vertices, faces), Geodesics(vertices, faces)
    kept.look_from(one(a, 1), np.inf)
    kept.look_from(one(b, 2), 1e-3)  # not far enough
    kept.look_from(one(b, 3), np.inf)
    for ways in (together.paths(a, b), kept.paths(a, b)):
        for k, way in enumerate(ways):
            alone = Geodesics(vertices, faces).path(one(a, k), one(b, k))
            assert length(way) == pytest.approx(length(alone), abs=1e-12)
            np.testing.assert_allclose(way[[0, -1]], alone[[0, -1]], atol=1e-15)


def test_two_parts_that_touch_in_a_point_are_connected_by_it() -> None:
    vertices = np.array([[-1.0, -1, 0], [-1, 1, 0], [0, 0, 0], [1, 1, 0], [1, -1, 0]])
    faces = np.array([[0, 2, 1], [2, 4, 3]])
    ends = [SurfacePoints(np.array([face]), np.full((1, 3), 1.0 / 3.0)) for face in (0, 1)]
    way = Geodesics(vertices, faces).path(*ends)
    np.testing.assert_allclose(way, [[-2.0 / 3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0 / 3.0, 0.0, 0.0]], atol=1e-15)


@pytest.mark.parametrize("radius", [0.004, 0.03])
def test_circles_on_the_torso_are_those_of_another_implementation(radius: float) -> None:
    torso = read_rig(default_rig_path())
    skin = Geodesics(torso.template, torso.faces)
    for name in ("nipple_L", "inframammary_fold_R"):
        place = torso.landmark_points((name,))
        rim = skin.circle(int(place.faces[0]), place.barycentric[0], radius)
        exact = exact_circle(torso.template, torso.faces, int(place.faces[0]), place.barycentric[0], radius)
        for points, line in ((rim, exact), (exact, rim)):
            assert gaps_to_line(points, line).max() < radius / 250.0  # chords


def gaps_to_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(M,) m from points to a closed polyline."""
    step = np.roll(line, -1, axis=0) - line
    share = np.einsum("mki,ki->mk", points[:, None] - line, step) / np.maximum((step * step).sum(axis=1), 1e-30)
    at = line + np.clip(share, 0.0, 1.0)[..., None] * step
    return np.linalg.norm(points[:, None] - at, axis=2).min(axis=1)


def lies_on(vertices: np.ndarray, faces: np.ndarray, way: np.ndarray) -> bool:
    """Every stretch between two points of the path lies within one triangle."""
    middles = np.concatenate([way, 0.5 * (way[1:] + way[:-1])])
    return bool(ClosestPointSearch(vertices, faces).query(middles).distances.max() < 1e-9)


def test_around_a_wall_the_path_bends_at_its_corners() -> None:
    """A sheet with a slit: the tape goes straight to the slit's end, and straight on."""
    vertices, faces = plane(0.2, 20)
    slit = (np.abs(vertices[faces].mean(axis=1)[:, 0]) < 0.01) & (vertices[faces].mean(axis=1)[:, 1] < 0.05)
    kept = faces[~slit]
    tip = [0.01, 0.05]
    start, end = ([x, -0.05, 0.0] for x in (-0.05, 0.05))
    at = [int(np.linalg.norm(vertices - place, axis=1).argmin()) for place in (start, end)]
    owners = [int(np.flatnonzero((kept == vertex).any(axis=1))[0]) for vertex in at]
    ends = [
        SurfacePoints(np.array([face]), (kept[face] == vertex)[None].astype(float))
        for face, vertex in zip(owners, at, strict=True)
    ]
    way = Geodesics(vertices, kept).path(*ends)
    expected = 2.0 * np.hypot(0.05 - tip[0], 0.05 + tip[1]) + 2.0 * tip[0]
    assert length(way) == pytest.approx(expected, abs=1e-12)
    for corner in ([-0.01, 0.05, 0.0], [0.01, 0.05, 0.0]):
        assert np.linalg.norm(way - corner, axis=1).min() < 1e-12
