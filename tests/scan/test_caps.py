"""Flat lids are cut away, and nothing else that is flat: tables, facets of a coarse mesh, smooth skin."""

import numpy as np
import pytest
import trimesh
from helpers.surfaces import plane, sphere

from breastrig.geometry.normals import face_crosses
from breastrig.scan.caps import caps
from breastrig.scan.clean import Surface, clean
from breastrig.scan.scan import Scan

TURN, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
Mesh = tuple[np.ndarray, np.ndarray]


def cleaned(vertices: np.ndarray, faces: np.ndarray) -> Surface:
    vertices = np.round(vertices @ (TURN * np.linalg.det(TURN)).T + [3.0, -1.0, 0.5], 5)  # as a file of mm rounds
    return clean(Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64))


def body() -> Mesh:
    vertices, faces = sphere(0.2)
    return vertices * [1.0, 1.6, 0.6], faces


def open_at(mesh: Mesh, axis: int, at: float, above: bool) -> Mesh:
    """The side of a closed mesh beyond a plane; what it was cut from ends on the plane."""
    vertices, faces = mesh
    sign = 1.0 if above else -1.0
    faces = faces[(sign * (vertices[faces][:, :, axis] - at) > 1e-9).any(axis=1)]
    vertices = vertices.copy()
    vertices[:, axis] = sign * np.maximum(sign * vertices[:, axis], sign * at)
    return vertices, faces


def closed(mesh: Mesh, aside: float = 0.0) -> Mesh:
    """With a fan over each opening, as programs fill holes; `aside` (m) of its middle it folds over itself."""
    filled = trimesh.Trimesh(*mesh, process=True)
    edges = filled.edges[trimesh.grouping.group_rows(filled.edges_sorted, require_count=1)]
    vertices, faces = filled.vertices, [filled.faces]
    for axis in range(3):
        for at in np.unique(np.round(vertices[edges[:, 0], axis], 6)):
            on = edges[(np.abs(vertices[edges][:, :, axis] - at) < 1e-7).all(axis=1)]
            if len(on) > 10:
                faces.append(np.column_stack([on[:, ::-1], np.full(len(on), len(vertices))]))
                middle = vertices[np.unique(on)].mean(axis=0) + np.roll([0.0, aside, aside], axis)
                vertices = np.vstack([vertices, middle])
    return vertices, np.concatenate(faces)


@pytest.mark.parametrize("aside", [0.0, 0.3])
@pytest.mark.parametrize("ends", [[(2, 0.0, True)], [(1, -0.25, True), (1, 0.25, False)]])
def test_a_scan_that_was_closed_is_what_it_was_before(ends: list[tuple[int, float, bool]], aside: float) -> None:
    shown = body()
    for end in ends:
        shown = open_at(shown, *end)
    before, after = cleaned(*shown), cleaned(*closed(shown, aside))
    assert len(after.faces) < len(closed(shown, aside)[1])
    corners = [np.sort(np.round(each.vertices[each.faces].mean(axis=1), 5), axis=0) for each in (before, after)]
    assert corners[0].shape == corners[1].shape
    assert np.allclose(*corners, atol=2e-5)
    assert "Flat lids" in after.notes[0]


def test_a_table_that_no_noise_touched_has_the_body_before_it() -> None:
    half = open_at(body(), 2, 0.0, True)
    table, squares = plane(0.8, 40)
    vertices = np.concatenate([half[0], table])
    assert cleaned(vertices, np.concatenate([half[1], len(half[0]) + squares])).notes == ()


@pytest.mark.parametrize("subdivisions", [2, 5])
def test_neither_facets_nor_smooth_skin_are_lids(subdivisions: int) -> None:
    ball = trimesh.creation.icosphere(subdivisions, 0.2)
    vertices = ball.vertices * [1.0, 1.6, 0.6]
    assert not caps(vertices, ball.faces, face_crosses(vertices, ball.faces)).any()
