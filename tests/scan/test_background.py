"""Floors and walls around a patient are cut away by the body that is found; a table under her stays a table."""

import json

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.fitting.hypotheses import ScanOrientation, orientation_from
from breastrig.fitting.prepare_scan import prepared
from breastrig.rig.similarity import Similarity
from breastrig.scan.clean import Surface

Mesh = tuple[np.ndarray, np.ndarray]


def plane(corner: list[float], along: list[float], across: list[float], count: int = 60) -> Mesh:
    """A noisy rectangle, facing along x across."""
    u, v = (each.ravel()[:, None] for each in np.meshgrid(*2 * [np.linspace(0.0, 1.0, count)], indexing="ij"))
    points = np.array(corner) + u * np.array(along) + v * np.array(across)
    points = points + np.random.default_rng(1).normal(0.0, 0.001, points.shape)
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]))
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([b, d, c])])


def body() -> Mesh:
    """A torso's front, 0.36 m wide and 0.5 m high, bulging to +Z."""
    a, y = (
        each.ravel() for each in np.meshgrid(np.linspace(0.0, np.pi, 60), np.linspace(-0.25, 0.25, 60), indexing="ij")
    )
    points = np.column_stack([0.18 * np.cos(a), y, 0.11 * np.sin(a) + 0.02 * np.cos(6.0 * y)])
    number = np.arange(3600).reshape(60, 60)
    p, q, r, s = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]))
    return points, np.concatenate([np.column_stack([p, r, q]), np.column_stack([q, r, s])])


def ball(middle: list[float], radius: float) -> Mesh:
    """Another person's hand, roughly."""
    points, faces = body()
    angle = np.arctan2(points[:, 2], points[:, 0])
    height = np.clip(points[:, 1] / 0.25, -0.999, 0.999)
    ring = np.sqrt(1.0 - height**2)
    return np.array(middle) + radius * np.column_stack([ring * np.cos(angle), height, ring * np.sin(angle)]), faces


FLOOR = plane([-0.7, -0.3, -0.7], [0.0, 0.0, 1.4], [1.4, 0.0, 0.0])
WALL = plane([-0.8, -0.3, -0.4], [1.6, 0.0, 0.0], [0.0, 1.3, 0.0])
TABLE = plane([-0.5, -0.6, -0.1], [1.0, 0.0, 0.0], [0.0, 1.2, 0.0])
HAND = ball([0.4, 0.0, 0.1], 0.08)


def joined(*meshes: Mesh) -> Surface:
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = np.concatenate([faces + offset for (_, faces), offset in zip(meshes, offsets, strict=False)])
    return Surface(np.concatenate([vertices for vertices, _ in meshes]), faces.astype(np.int64), ())


@pytest.mark.parametrize(
    "around", [[FLOOR], [WALL], [FLOOR, WALL], [WALL, FLOOR, HAND]], ids=["floor", "wall", "both", "with a hand"]
)
def test_a_body_in_a_room_is_left_alone(around: list[Mesh]) -> None:
    alone, ready = prepared(joined(body()), "auto"), prepared(joined(body(), *around), "auto")
    np.testing.assert_array_equal(ready.target.vertices, alone.target.vertices)
    assert ready.frame.stance == "standing"
    assert ready.table_triangles == 0
    np.testing.assert_allclose(ready.frame.front, alone.frame.front, atol=1e-12)
    whole, left = (sum(float(area) for area in areas_of(each)) for each in (joined(body(), *around), joined(body())))
    assert ready.cut_away == pytest.approx(whole - left)
    assert ready.notes[-1] == f"A floor or wall and what stood by it were cut away: {1e4 * ready.cut_away:,.0f} cm²."


def areas_of(surface: Surface) -> np.ndarray:
    a, b, c = (surface.vertices[surface.faces[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def test_a_table_under_the_body_is_a_table_still() -> None:
    ready = prepared(joined(body(), TABLE), "auto")
    assert ready.frame.stance == "supine"
    assert ready.frame.background == ()
    assert ready.table_triangles == len(TABLE[1])
    assert ready.cut_away == 0.0


@pytest.mark.parametrize("stance", ["auto", "standing", "supine"])
def test_a_body_alone_is_not_touched(stance: str) -> None:
    surface = joined(body())
    ready = prepared(surface, stance)
    assert ready.surface is surface
    assert ready.target.faces is surface.faces
    assert ready.cut_away == 0.0


@pytest.mark.parametrize("behind", [0.02, 0.10, 0.18])
def test_walls_are_cut_from_a_known_standing_body_however_close_they_are(behind: float) -> None:
    near = plane([-0.8, -0.3, -behind], [1.6, 0.0, 0.0], [0.0, 1.3, 0.0])
    alone, surface = prepared(joined(body()), "standing"), joined(body(), near)
    ready = prepared(surface, "standing")
    np.testing.assert_array_equal(ready.target.vertices, alone.target.vertices)
    assert ready.target.table is None
    assert ready.table_triangles == 0
    assert len(ready.frame.background) == 1
    lying = prepared(surface, "auto")  # what the upload takes it for
    assert lying.frame.stance == "supine"
    again = prepared(surface, "standing", lying.frame)
    np.testing.assert_array_equal(again.target.vertices, alone.target.vertices)
    assert again.target.table is None


def test_what_stands_by_a_wall_is_named_with_a_place_on_each_piece() -> None:
    ready = prepared(joined(body(), WALL, HAND), "auto")
    (hand,) = ready.beside
    assert np.linalg.norm(hand.place - [0.4, 0.0, 0.1]) == pytest.approx(0.08, abs=0.01)


def test_fits_cut_what_the_upload_has_cut() -> None:
    surface = joined(body(), FLOOR, WALL)
    ready = prepared(surface, "auto")
    for stance in ("auto", "standing", "supine"):
        again = prepared(surface, stance, ready.frame)
        np.testing.assert_array_equal(again.target.vertices, ready.target.vertices)
        assert again.cut_away == ready.cut_away


def test_the_planes_are_kept_with_the_scan() -> None:
    rig, ready = toy_rig(), prepared(joined(body(), FLOOR, WALL), "auto")
    place = Similarity(1.0, np.eye(3), np.zeros(3))
    known = ScanOrientation(rig.sha256, ready.frame, place, 0.5, "standing", "So it is.")
    kept = orientation_from(json.loads(json.dumps(known.facts())), rig)
    assert len(kept.frame.background) == 2
    again = prepared(joined(body(), FLOOR, WALL), "auto", kept.frame)
    np.testing.assert_array_equal(again.target.vertices, ready.target.vertices)
    alone = ScanOrientation(rig.sha256, prepared(joined(body()), "auto").frame, place, 0.5, "standing", "So it is.")
    assert orientation_from(alone.facts(), rig).frame.background == ()
