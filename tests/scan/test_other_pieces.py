"""Another person's hand beside the body goes before the fit; pieces of the body's own skin stay."""

from functools import cache

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.core.assets import asset_folder
from breastrig.fitting.prepare_scan import PreparedScan, prepared
from breastrig.geometry.normals import face_areas
from breastrig.scan.around.other_pieces import without_other_pieces
from breastrig.scan.clean import Surface, clean
from breastrig.scan.read import read_scan

HEIGHT, RADIUS = 0.25, 0.16  # m


def front() -> tuple[np.ndarray, np.ndarray]:
    """Half a barrel around Y, seen from +Z; and its triangles."""
    angle, y = (
        each.ravel()
        for each in np.meshgrid(np.linspace(0.0, np.pi, 90), np.linspace(-HEIGHT, HEIGHT, 90), indexing="ij")
    )
    number = np.arange(8100).reshape(90, 90)
    p, q, r, s = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]))
    faces = np.concatenate([np.column_stack([p, r, q]), np.column_stack([q, r, s])])
    return np.column_stack([RADIUS * np.cos(angle), y, RADIUS * np.sin(angle)]), faces


def hand(middle: list[float], seen_from: list[float] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """As long as a hand; all around, or what is seen of it from one side."""
    vertices, faces = sphere(0.05, 4)
    vertices = vertices * [0.6, 1.6, 0.8]
    if seen_from is not None:
        crosses = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
        faces = faces[crosses @ np.array(seen_from) > 0.0]
    return vertices + middle, faces


def beside(vertices: np.ndarray, faces: np.ndarray, other: tuple[np.ndarray, np.ndarray]) -> Surface:
    joined = np.concatenate([vertices, other[0]]), np.concatenate([faces, other[1] + len(vertices)])
    return Surface(*joined, ())


PLACES = {"flank": [0.22, -0.1, 0.02], "shoulder": [0.08, 0.35, 0.1], "front": [-0.03, 0.05, 0.24]}


@pytest.mark.parametrize(
    ("place", "seen_from", "stance"),
    [("flank", None, "auto"), ("shoulder", [0.2, 0.1, 1.0], "standing"), ("front", [0.2, 0.1, 1.0], "supine")],
)
def test_a_hand_goes_and_is_said(place: str, seen_from: list[float] | None, stance: str) -> None:
    vertices, faces = front()
    other = hand(PLACES[place], seen_from)
    ready = prepared(beside(vertices, faces, other), stance)
    alone = front_alone(stance)
    np.testing.assert_array_equal(ready.target.vertices, alone.target.vertices)
    np.testing.assert_array_equal(ready.target.faces, alone.target.faces)
    area = face_areas(*other).sum()
    assert ready.cut_away == pytest.approx(area)
    assert ready.notes == (f"A piece beside the body was cut away: {1e4 * area:,.0f} cm².",)
    (piece,) = ready.beside
    assert piece.area == pytest.approx(area)
    assert np.linalg.norm(other[0] - piece.place, axis=1).min() < 0.006
    if stance != "supine":
        np.testing.assert_allclose(ready.frame.front, alone.frame.front, atol=1e-12)


def clean_of(vertices: np.ndarray, faces: np.ndarray) -> Surface:
    return Surface(vertices, faces, ())


@cache
def front_alone(stance: str) -> PreparedScan:
    return prepared(clean_of(*front()), stance)


@pytest.mark.parametrize(("tear", "width"), [("along", 0.035), ("across", 0.01), ("island", 0.035)])
def test_skin_that_was_torn_apart_stays(tear: str, width: float) -> None:
    vertices, faces = front()
    x, y, _ = vertices[faces].mean(axis=1).T
    gap = {
        "along": np.abs(x - 0.05) < width / 2,
        "across": np.abs(y - 0.15) < width / 2,
        "island": np.abs(np.hypot(x, y) - 0.06) < width / 2,
    }[tear]
    surface = clean_of(vertices, faces[~gap])
    ready = prepared(surface, "auto")
    assert ready.surface is surface
    assert ready.beside == ()


def test_an_island_of_an_island_stays_and_a_hand_beside_them_goes() -> None:
    vertices, faces = front()
    x, y, _ = vertices[faces].mean(axis=1).T
    rings = (np.abs(np.hypot(x, y) - 0.09) < 0.01) | (np.abs(np.hypot(x, y) - 0.045) < 0.01)
    ready = prepared(beside(vertices, faces[~rings], hand(PLACES["flank"])), "auto")
    assert len(ready.beside) == 1
    assert len(ready.target.faces) == np.count_nonzero(~rings)


def test_a_hand_with_its_arm_goes_beside_a_part_of_a_body_and_another_side_of_her_stays() -> None:
    """Skin all around an arm is as much as a side of a trunk, but not as seen from one place."""
    vertices, faces = front()
    x = vertices[faces].mean(axis=1)[:, 0]
    side, other = faces[x > 0.0], faces[x < -0.07]
    arm = hand([0.0, 0.0, 0.0])
    arm = arm[0] * [1.5, 2.5, 1.5] + [0.4, 0.0, 0.1], arm[1]
    areas = [face_areas(vertices, each).sum() for each in (side, other)]
    assert 0.5 < face_areas(*arm).sum() / areas[0] < 1.0
    ready = prepared(beside(vertices, side, arm), "auto")
    assert len(ready.beside) == 1
    assert len(ready.target.faces) == len(side)
    assert 0.5 < areas[1] / areas[0] < 1.0
    both = prepared(clean_of(vertices, np.concatenate([side, other])), "auto")
    assert both.beside == ()


def test_a_hand_over_a_lying_patient_goes_and_her_table_is_still_one() -> None:
    scan = clean(read_scan(asset_folder("example") / "supine" / "scan.ply", None, "auto", texture=False))
    alone = prepared(scan, "auto")
    assert alone.frame.table is not None
    body = alone.target.vertices
    above = body.mean(axis=0) + alone.frame.front * (np.ptp((body - body.mean(axis=0)) @ alone.frame.front) + 0.1)
    ready = prepared(beside(scan.vertices, scan.faces, hand(above.tolist())), "auto")
    np.testing.assert_array_equal(ready.target.vertices, alone.target.vertices)
    assert ready.table_triangles == alone.table_triangles
    assert len(ready.beside) == 1
    assert len(ready.surface.faces) == len(scan.faces)


def test_a_flat_piece_is_no_body_however_large() -> None:
    vertices, faces = front()
    corner = np.array([[-1.0, -0.6, -1.0], [1.0, -0.6, -1.0], [1.0, -0.6, 1.0], [-1.0, -0.6, 1.0]])  # a floor's patch
    places = np.concatenate([vertices, corner])
    joined = np.concatenate([faces, np.array([[0, 2, 1], [0, 3, 2]]) + len(vertices)])
    hers, (piece,) = without_other_pieces(places, joined, in_room=False)
    np.testing.assert_array_equal(hers, np.arange(len(joined)) < len(faces))
    assert piece.area == pytest.approx(4.0)
