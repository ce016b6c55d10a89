"""Two drawings of known distance, and their picture."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.drawings.superimposition.gaps import gaps
from breastrig.geometry.polyline import Polyline


def shape(points: Array, name: str = "cut", closed: bool = False) -> Polyline:
    return Polyline(name, closed, "#000000", points, np.zeros(len(points), np.bool_))


def straight(length: float, height: float, points: int = 2) -> Array:
    return np.stack([np.linspace(0.0, length, points), np.full(points, height), np.zeros(points)], axis=1)


def circle(radius: float) -> Array:
    angles = 2.0 * np.pi * np.arange(720) / 720
    return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(720)], axis=1)


def test_parallel_lines_are_as_far_apart_as_they_are_however_many_points_they_have() -> None:
    (gap,) = gaps([shape(straight(0.1, 0.0))], [shape(straight(0.1, 0.002, points=57))])
    assert (gap.mean_mm, gap.p95_mm, gap.max_mm) == pytest.approx((2.0, 2.0, 2.0))


def test_the_part_that_the_other_line_lacks_counts_too() -> None:
    (gap,) = gaps([shape(straight(0.1, 0.0))], [shape(straight(0.05, 0.0))])
    assert gap.max_mm == pytest.approx(50.0)
    (turned,) = gaps([shape(straight(0.05, 0.0))], [shape(straight(0.1, 0.0))])
    assert np.sort(gap.distances) == pytest.approx(np.sort(turned.distances))


def test_circles_around_one_centre_differ_by_their_radii() -> None:
    (gap,) = gaps([shape(circle(0.050), closed=True)], [shape(circle(0.053), closed=True)])
    assert (gap.mean_mm, gap.max_mm) == pytest.approx((3.0, 3.0), abs=0.02)


def test_a_single_point_is_compared_with_a_single_point() -> None:
    (gap,) = gaps([shape(np.zeros((1, 3)))], [shape(np.array([[0.0, 0.003, 0.004]]))])
    assert gap.max_mm == pytest.approx(5.0)


def test_drawings_without_a_common_name_are_refused() -> None:
    with pytest.raises(BadDrawing, match="no shape of the same name"):
        gaps([shape(circle(0.05), "a")], [shape(circle(0.05), "b")])
