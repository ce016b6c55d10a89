"""Cleaning and the proposed frame on hand-made scans."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.surfaces import plane, sphere

from breastrig.core.errors import BadScan
from breastrig.scan.clean import clean
from breastrig.scan.orient import propose_frame
from breastrig.scan.scan import Scan


def scan(vertices: np.ndarray, faces: np.ndarray) -> Scan:
    return Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64)


def joined(*parts: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [triangles + offset for (_, triangles), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def test_repeated_vertices_are_welded_and_nothing_else_changes() -> None:
    vertices, faces = sphere()
    cleaned = clean(scan(vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)))
    assert (len(cleaned.vertices), len(cleaned.faces)) == (len(vertices), len(faces))
    assert cleaned.notes == ()


def test_dust_and_triangles_without_area_are_left_out_without_a_word() -> None:
    body, (dust, dust_faces) = sphere(), plane(0.01, 2)
    vertices, faces = joined(body, (dust + np.array([0.5, 0.0, 0.0]), dust_faces))
    cleaned = clean(scan(vertices, np.concatenate([faces, [[0, 0, 1]]])))
    assert len(cleaned.faces) == len(body[1])
    assert cleaned.notes == ()


@pytest.mark.parametrize("faces", [np.array([[0, 1, 2]]), np.array([[0, 0, 0]])])
def test_too_little_to_fit_is_one_sentence(faces: np.ndarray) -> None:
    with pytest.raises(BadScan, match=r"triangle"):
        clean(scan(np.eye(3), faces))


def lying(turn: np.ndarray) -> Scan:
    """A half ball on a table, the front of the ball along +Z before the turn."""
    vertices, faces = sphere(0.25)
    front = faces[(vertices[faces][:, :, 2] > 0.0).all(axis=1)]
    vertices, faces = joined((vertices, front), plane(0.8, 40))
    return scan(vertices @ turn.T, faces)


@pytest.mark.parametrize("axis", range(3))
def test_a_table_behind_the_body_means_supine_and_shows_the_front(axis: int) -> None:
    turn = np.roll(np.eye(3), axis, axis=0)
    lies = lying(turn)
    frame = propose_frame(lies.vertices, lies.faces)
    assert frame.stance == "supine"
    assert frame.front @ turn[:, 2] > 0.99
    np.testing.assert_allclose(frame.rotation.T @ frame.rotation, np.eye(3), atol=1e-12)
    assert abs(np.linalg.det(frame.rotation) - 1.0) < 1e-12


def test_a_scan_of_the_front_faces_its_camera_and_stands() -> None:
    lies = lying(np.eye(3))
    without_table = replace(lies, faces=lies.faces[lies.vertices[lies.faces][:, :, 2].min(axis=1) > 1e-9])
    cleaned = clean(without_table)
    frame = propose_frame(cleaned.vertices, cleaned.faces)
    assert frame.stance == "standing"
    assert frame.front[2] > 0.99
    np.testing.assert_allclose(frame.up, [0, 1, 0], atol=0.05)


BODIES = {
    "box": trimesh.creation.box((0.5, 0.5, 0.5)),
    "finer box": trimesh.creation.box((0.5, 0.5, 0.5)).subdivide().subdivide(),
    "prism": trimesh.creation.cylinder(0.2, 0.5, sections=8),
    "cylinder": trimesh.creation.cylinder(0.2, 0.5, sections=64),
    "cone": trimesh.creation.cone(0.3, 0.6),
    "ball": trimesh.creation.icosphere(3, 0.3),
    "hull": trimesh.convex.convex_hull(np.random.default_rng(1).uniform(-0.5, 0.5, (60, 3))),
}


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("size", [1.0, 4.0])
def test_a_body_with_flat_sides_that_is_no_torso_gets_a_proposal_and_no_error(body: str, size: float) -> None:
    mesh = BODIES[body]
    frame = propose_frame(size * np.asarray(mesh.vertices), np.asarray(mesh.faces))
    np.testing.assert_allclose(frame.rotation.T @ frame.rotation, np.eye(3), atol=1e-9)
    assert 0.0 <= frame.confidence <= 1.0
