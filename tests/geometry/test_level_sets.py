"""Parts of a plane and a sphere above a level, and lines of one level on a plane."""

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.fields.implicit_surface import implicit_surface
from breastrig.geometry.fields.level_sets import crossings, longest_loop, part_above
from breastrig.geometry.normals import face_areas, face_normals


@pytest.mark.parametrize("level", [-0.0333, 0.0, 0.0477])
def test_half_planes_are_cut_exactly(level: float) -> None:
    vertices, faces = plane(0.2, 20)
    values = vertices[:, 0] + 0.5 * vertices[:, 1]
    part, triangles = part_above(vertices, faces, values, level)
    assert (part[:, 0] + 0.5 * part[:, 1] > level - 1e-12).all()
    below, under = part_above(vertices, faces, -values, -level)
    total = face_areas(part, triangles).sum() + face_areas(below, under).sum()
    assert total == pytest.approx(0.04, abs=1e-12)
    kept = face_areas(part, triangles) > 1e-14
    assert face_normals(part, triangles[kept])[:, 2] == pytest.approx(1.0)
    line = crossings(vertices, faces, values, level)
    assert line[:, 0] + 0.5 * line[:, 1] == pytest.approx(level, abs=1e-12)


def test_a_cap_of_a_sphere_has_one_border_and_moves_with_the_level() -> None:
    vertices, faces = sphere(0.1, 4)
    areas = []
    for level in (0.013, 0.033, 0.053):
        part, triangles = part_above(vertices, faces, vertices[:, 2], level)
        assert len(boundary_loops(triangles)) == 1
        areas.append(face_areas(part, triangles).sum())
    assert areas == pytest.approx([2 * np.pi * 0.1 * (0.1 - z) for z in (0.013, 0.033, 0.053)], rel=0.01)


def test_all_or_nothing() -> None:
    vertices, faces = plane()
    assert len(part_above(vertices, faces, vertices[:, 0], 1.0)[1]) == 0
    assert len(part_above(vertices, faces, vertices[:, 0], -1.0)[1]) == len(faces)
    assert len(crossings(vertices, faces, vertices[:, 0], 1.0)) == 0


def test_the_longest_of_two_loops_is_taken_in_order() -> None:
    vertices, faces = plane(0.2, 40)
    values = np.minimum(
        np.linalg.norm(vertices - [0.04, 0.0, 0.0], axis=1), np.linalg.norm(vertices - [-0.06, 0.0, 0.0], axis=1) + 0.01
    )
    loop = longest_loop(faces, values, 0.03)
    ends = vertices[loop.edges]
    assert (ends[:, :, 0] > 0.0).all()  # the circle of 30 mm, not the one of 20
    inside = values[loop.edges] < 0.03
    assert (inside.sum(axis=1) == 1).all()  # every edge crosses
    middles = ends.mean(axis=1)
    assert np.linalg.norm(middles - np.roll(middles, 1, axis=0), axis=1).max() < 0.006  # one after the other
    for face, edge in zip(loop.faces, loop.edges, strict=True):
        assert set(edge) <= set(faces[face])


def test_a_loop_cut_by_the_border_is_none() -> None:
    vertices, faces = plane(0.2, 40)
    assert longest_loop(faces, np.linalg.norm(vertices - [0.09, 0.0, 0.0], axis=1), 0.03) is None


def test_a_level_that_is_never_reached_is_none() -> None:
    vertices, faces = plane(0.2, 10)
    assert longest_loop(faces, np.linalg.norm(vertices, axis=1), 9.0) is None


def test_the_surface_through_points_of_a_sphere_is_that_sphere() -> None:
    """Also where it touches the border of all points, along each axis."""
    points, _ = sphere(0.1, 4)
    vertices, faces = implicit_surface(points, points / 0.1, 6e-3, 4e-3, 0.01)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(0.1, abs=5e-4)
    assert len(boundary_loops(faces)) == 0
    assert face_areas(vertices, faces).sum() == pytest.approx(4 * np.pi * 0.01, rel=0.01)
    assert (np.einsum("fi,fi->f", face_normals(vertices, faces), vertices[faces].mean(axis=1)) > 0.0).all()
