import numpy as np
import pytest

from breastrig.geometry.boundary import boundary_edges, boundary_loops, boundary_vertices

SOLID = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def grid(columns: int, rows: int) -> np.ndarray:
    """Triangles of a flat grid of columns x rows squares, counter-clockwise from +Z."""
    corner = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    return np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])


def test_a_closed_solid_has_no_border() -> None:
    assert len(boundary_edges(SOLID)) == 0
    assert not boundary_vertices(SOLID, 4).any()
    assert boundary_loops(SOLID) == []


def test_no_triangles_have_no_border() -> None:
    nothing = np.zeros((0, 3), dtype=np.int64)
    assert boundary_edges(nothing).shape == (0, 2)
    assert boundary_loops(nothing) == []


def test_the_border_of_a_triangle_runs_the_way_of_the_triangle() -> None:
    (loop,) = boundary_loops(np.array([[4, 7, 2]]))
    assert list(np.roll(loop, -int(np.argmin(loop)))) == [2, 4, 7]


def test_a_sheet_with_a_hole_has_two_loops_the_longer_first() -> None:
    faces = grid(5, 5)
    hole = {14, 15, 20, 21}  # one square in the middle
    faces = np.array([face for face in faces if not set(face) <= hole])
    outer, inner = boundary_loops(faces)
    assert len(outer) == 20
    assert set(inner) == hole
    assert boundary_vertices(faces, 36).sum() == 24


def test_two_holes_that_touch_in_one_corner_are_parted() -> None:
    faces = grid(6, 6)
    holes = ({8, 9, 15, 16}, {16, 17, 23, 24})
    faces = np.array([face for face in faces if not any(set(face) <= hole for hole in holes)])
    loops = boundary_loops(faces)
    assert [len(loop) for loop in loops] == [24, 4, 4]
    assert all(len(set(loop)) == len(loop) for loop in loops)


def test_triangles_that_disagree_about_their_direction_are_reported() -> None:
    with pytest.raises(ValueError, match="disagree"):
        boundary_loops(np.array([[0, 1, 2], [0, 1, 3]]))
