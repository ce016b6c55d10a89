"""Paths as short as the exact distance says, on meshes where that is easy, hard, and known."""

import numpy as np
import pytest
import trimesh
from helpers.surfaces import plane

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics, length
from breastrig.geometry.shortest_path import PathTracer
from breastrig.geometry.surface_points import SurfacePoints
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


@pytest.mark.parametrize("make", [crumpled, full_of_holes, box, needles, lambda rng: plane(0.2, 12)])
def test_a_path_lies_on_the_mesh_and_is_as_long_as_the_exact_distance(make, rng: np.random.Generator) -> None:
    vertices, faces = make(rng)
    measured = Geodesics(vertices, faces)
    checked = 0
    for face, corner in zip(rng.integers(0, len(faces), 4), rng.integers(0, 3, 4), strict=True):
        distances = measured.distances(int(face), np.eye(3)[corner])
        reached = np.flatnonzero(np.isfinite(distances))
        tracer = PathTracer(vertices, faces, np.where(np.isfinite(distances), distances, 1e9))
        for start in rng.choice(reached, min(15, len(reached)), replace=False):
            way = tracer.path(int(start))
            np.testing.assert_array_equal(way[[0, -1]], [vertices[start], vertices[faces[face, corner]]])
            assert length(way) == pytest.approx(distances[start], abs=1e-12)
            assert lies_on(vertices, faces, way)
            checked += 1
    assert checked > 20


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
