"""Resampled polylines."""

import numpy as np

from breastrig.geometry.polyline import resampled


def test_points_lie_evenly_and_ends_stay() -> None:
    line = np.array([[0.0, 0, 0], [0.01, 0, 0], [0.1, 0, 0]])
    even = resampled(line, 0.003, closed=False)
    np.testing.assert_allclose(np.diff(even[:, 0]), 0.1 / 34, atol=1e-12)
    np.testing.assert_array_equal(even[[0, -1]], line[[0, -1]])


def test_a_closed_line_is_closed_without_repeating_its_start() -> None:
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    even = resampled(ring, 0.1, closed=True)
    steps = np.linalg.norm(np.diff(np.concatenate([even, even[:1]]), axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-3)


def test_a_line_without_length_is_one_point() -> None:
    assert resampled(np.zeros((4, 3)), 0.003, closed=True).shape == (1, 3)
