"""The one polyline: what it promises, and what is asked of it everywhere."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.geometry.polyline import Polyline, parts

SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
OPEN = Polyline("cut", False, "#101010", SQUARE, np.array([False, True, True, False]), (1, 2), np.full(4, 0.002))
CLOSED = replace(OPEN, closed=True)


def test_nobody_can_change_its_points() -> None:
    points = SQUARE.copy()
    line = replace(OPEN, points=points)
    points[0] = 9.0
    np.testing.assert_array_equal(line.points, SQUARE)
    for array in (line.points, line.bridged, line.error):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_moved_it_keeps_everything_but_its_place() -> None:
    moved = OPEN.moved(np.array([0.0, 0.0, 2.0]))
    np.testing.assert_array_equal(moved.points, SQUARE + np.array([0.0, 0.0, 2.0]))
    assert (moved.name, moved.closed, moved.color, moved.corners) == ("cut", False, "#101010", (1, 2))
    np.testing.assert_array_equal(moved.bridged, OPEN.bridged)
    np.testing.assert_array_equal(moved.error, OPEN.error)


@pytest.mark.parametrize(
    ("count", "closed", "edges"),
    [
        (1, False, []),
        (1, True, []),
        (2, False, [[0, 1]]),
        (2, True, [[0, 1]]),
        (3, False, [[0, 1], [1, 2]]),
        (3, True, [[0, 1], [1, 2], [2, 0]]),
    ],
)
def test_edges_join_neighbours_and_close_what_has_an_inside(count: int, closed: bool, edges: list[list[int]]) -> None:
    line = Polyline("cut", closed, "#101010", SQUARE[:count], np.zeros(count, np.bool_))
    assert line.edges.tolist() == edges
    assert line.edges.shape == (len(edges), 2)


def test_runs_are_cut_where_the_line_leaves_the_skin() -> None:
    assert [(run.tolist(), bridged) for run, bridged in OPEN.runs()] == [
        (SQUARE[:1].tolist(), False),
        (SQUARE[1:3].tolist(), True),
        (SQUARE[3:].tolist(), False),
    ]
    *_, (last, bridged) = CLOSED.runs()
    np.testing.assert_array_equal(last, SQUARE[[3, 0]])
    assert not bridged
    ((whole, bridged),) = replace(CLOSED, bridged=np.ones(4, np.bool_)).runs()
    np.testing.assert_array_equal(whole, CLOSED.outline)
    assert bridged


def test_the_nearest_place_may_lie_between_points_and_on_the_closing_edge() -> None:
    places = np.array([[0.5, -0.3, 0.0], [-0.2, 0.5, 0.0], [1.0, 1.0, 0.7]])
    np.testing.assert_allclose(CLOSED.distances(places), [0.3, 0.2, 0.7])
    np.testing.assert_allclose(OPEN.distances(places), [0.3, np.hypot(0.2, 0.5), 0.7])
    dot = Polyline("dot", True, "#101010", SQUARE[:1], np.zeros(1, np.bool_))
    np.testing.assert_allclose(dot.distances(places[:1]), [np.hypot(0.5, 0.3)])
    twice = replace(dot, points=np.zeros((2, 3)), bridged=np.zeros(2, np.bool_))
    np.testing.assert_allclose(twice.distances(places[:1]), [np.hypot(0.5, 0.3)])


@pytest.mark.parametrize(
    "wrong",
    [
        {"points": SQUARE[:, :2]},
        {"points": SQUARE[:3]},
        {"points": SQUARE[:0], "bridged": np.zeros(0, np.bool_), "corners": (), "error": None},
        {"bridged": np.zeros(3, np.bool_)},
        {"error": np.zeros(3)},
        {"corners": (4,)},
    ],
)
def test_what_is_said_of_its_points_is_said_of_each(wrong: dict) -> None:
    with pytest.raises(AssertionError):
        replace(OPEN, **wrong)


def test_parts_say_where_each_line_stands_among_all_points() -> None:
    lines = [OPEN, replace(OPEN, points=SQUARE[:1], bridged=np.ones(1, np.bool_), corners=(), error=None), CLOSED]
    together = np.concatenate([line.points for line in lines])
    for line, part in zip(lines, parts(lines), strict=True):
        np.testing.assert_array_equal(together[part], line.points)
    assert parts([]) == []
