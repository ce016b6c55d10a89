"""The clock on the breast where its circle is folded, and as an observer facing the patient reads it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from breastrig.core.errors import BadDrawing
from breastrig.drawings.clock import clock_place, on_clock
from breastrig.geometry.rotations import exp_so3
from breastrig.geometry.surface_points import SurfacePoints

CENTRE = SurfacePoints(np.array([0]), np.array([[1.0, 0.0, 0.0]]))
ROUND = [(angle, 0.05) for angle in range(0, 360, 2)]
FOLDED = [(angle, 0.05) for angle in (*range(0, 101, 5), *range(130, 360, 5))]
FOLDED[21:21] = [(95, 0.04), (80, 0.04), (80, 0.03), (95, 0.03), (110, 0.03)]  # crosses 3 o'clock three times


def skin(rim: list[tuple[float, float]], turn: np.ndarray) -> Any:
    """A skin whose circle is a rim of (degrees clockwise from 12 for the observer, m) around the origin."""
    angles, radii = np.radians([angle for angle, _ in rim]), np.array([radius for _, radius in rim])
    # counter-clockwise seen from the front, as circles on the skin are; the observer's right is her left, +X
    points = np.stack([radii * np.sin(angles), radii * np.cos(angles), np.zeros(len(rim))], axis=1)[::-1] @ turn.T
    own = SimpleNamespace(axes=turn, at=lambda where: np.zeros((1, 3)) if where is CENTRE else where)
    own.geodesics = SimpleNamespace(
        circle_points=lambda *_: points, distance=lambda _, place: float(np.linalg.norm(place))
    )
    own.nearest = lambda places: places
    return own


@pytest.mark.parametrize("turn", [np.eye(3), exp_so3(np.array([1.2, -0.4, 0.3]))])
def test_three_is_towards_her_left_and_twelve_towards_her_head(turn: np.ndarray) -> None:
    angles = np.radians([0.0, 90.0, 180.0, 270.0, 37.0])
    wanted = 0.05 * np.stack([np.sin(angles), np.cos(angles), np.zeros(5)], axis=1) @ turn.T
    round_skin = skin(ROUND, turn)
    places = np.asarray(on_clock(round_skin, CENTRE, 0.05, angles))
    np.testing.assert_allclose(places, wanted, atol=2e-5)
    for angle, place in zip(angles, places, strict=True):
        distance, read = clock_place(round_skin, CENTRE, place[None])
        assert distance == pytest.approx(0.05, abs=2e-5)
        assert np.exp(1j * read) == pytest.approx(np.exp(1j * angle), abs=1e-6)


def test_where_the_circle_crosses_a_direction_three_times_the_outermost_is_seen() -> None:
    (place,) = np.asarray(on_clock(skin(FOLDED, np.eye(3)), CENTRE, 0.05, np.radians([90.0])))
    np.testing.assert_allclose(place, [0.05, 0.0, 0.0], atol=1e-4)


def test_a_circle_that_does_not_go_around_has_no_such_hour() -> None:
    half = [(angle, 0.05) for angle in range(100, 260, 5)]
    with pytest.raises(BadDrawing, match="shows no such direction"):
        on_clock(
            skin(half + [(angle, 0.02) for angle in range(255, 100, -5)], np.eye(3)), CENTRE, 0.05, np.array([0.0])
        )
