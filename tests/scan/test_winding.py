"""Inside-out and mixed triangles are turned, right ones are left alone."""

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.scan.clean import clean
from breastrig.scan.scan import Scan
from breastrig.scan.winding import outwards


def front_and_table() -> tuple[np.ndarray, np.ndarray]:
    """The front half of a ball over a table that faces the same way."""
    vertices, faces = sphere(0.25)
    front = faces[(vertices[faces][:, :, 2] > 0.0).all(axis=1)]
    table, cells = plane(0.8, 20)
    return np.concatenate([vertices, table - np.array([0.0, 0.0, 0.02])]), np.concatenate(
        [front, cells + len(vertices)]
    )


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """The same triangles in the same order with the same winding."""
    start = (np.arange(3) + a.argmin(axis=1)[:, None]) % 3, (np.arange(3) + b.argmin(axis=1)[:, None]) % 3
    return bool((np.take_along_axis(a, start[0], 1) == np.take_along_axis(b, start[1], 1)).all())


def test_right_triangles_stay() -> None:
    vertices, faces = front_and_table()
    turned, count = outwards(vertices, faces)
    assert count == 0
    np.testing.assert_array_equal(turned, faces)


def test_inside_out_is_turned() -> None:
    vertices, faces = front_and_table()
    turned, count = outwards(vertices, faces[:, ::-1])
    assert count == len(faces)
    assert same(turned, faces)


@pytest.mark.parametrize("seed", range(3))
def test_mixed_is_turned_the_right_way(seed: int) -> None:
    vertices, faces = front_and_table()
    wrong = np.random.default_rng(seed).random(len(faces)) < 0.4
    turned, count = outwards(vertices, np.where(wrong[:, None], faces[:, ::-1], faces))
    assert count == wrong.sum()
    assert same(turned, faces)


def test_many_pieces_are_each_turned(rng: np.random.Generator) -> None:
    vertices, faces = sphere(0.1, 2)
    places = 0.5 * rng.normal(size=(30, 1, 3))
    vertices, faces = (places + vertices).reshape(-1, 3), np.concatenate([faces + k * len(vertices) for k in range(30)])
    wrong = rng.random(len(faces)) < 0.5
    turned, count = outwards(vertices, np.where(wrong[:, None], faces[:, ::-1], faces))
    assert count == wrong.sum()
    assert same(turned, faces)


def test_a_round_scrap_does_not_turn_a_flat_body() -> None:
    """One side of a body may be flatter than ROUND; a bowl beside it (an armpit's end) is rounder, and hollow."""
    ball, faces = sphere(0.25)
    heights = ball[faces][:, :, 2]
    body, bowl = faces[(heights > 0.0).all(axis=1)], faces[(heights < 0.0).all(axis=1)][:, ::-1]
    table, cells = plane(0.8, 20)
    dome, scrap = ball * [1.0, 1.0, 0.05], 0.1 * ball + [0.3, 0.0, 0.1]
    shown = np.concatenate([body, cells + len(ball)])
    turned, _ = outwards(
        np.concatenate([dome, table - [0.0, 0.0, 0.02], scrap]),
        np.concatenate([shown, bowl + len(ball) + len(table)]),
    )
    np.testing.assert_array_equal(turned[: len(shown)], shown)


def test_edges_of_three_triangles_do_not_confuse_it() -> None:
    vertices, faces = sphere(0.1)
    fin = np.array([[faces[0, 0], faces[0, 1], len(vertices)]])
    turned, _ = outwards(np.concatenate([vertices, [[0.3, 0.0, 0.0]]]), np.concatenate([faces[:, ::-1], fin]))
    assert same(turned[:-1], faces)


def test_cleaning_turns() -> None:
    vertices, faces = sphere()
    cleaned = clean(Scan(vertices, faces[:, ::-1], "m", 1.0, "As asked for.", "0" * 64))
    assert same(cleaned.faces, faces)
    assert cleaned.notes == ()
