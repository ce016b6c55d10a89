"""Nearest points by comparing all with all: those of a k-d tree."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from breastrig.fitting.starts import rigid_search
from breastrig.fitting.starts.rigid_search import NearestPoints

ROUNDING = 1e-5  # m; what single precision leaves open a body's size away from the origin


def test_they_are_those_of_a_tree_and_their_distances_are_exact() -> None:
    rng = np.random.default_rng(4)
    points, places = rng.normal(size=(700, 6)) + 3.0, rng.normal(size=(9, 81, 6)) + 3.0
    for reach in (0.8, np.inf):
        wanted, which = cKDTree(points).query(places, distance_upper_bound=reach)
        distances, nearest = NearestPoints(points).query(places, reach)
        found = np.isfinite(wanted)
        assert found.any()
        np.testing.assert_array_equal(nearest, np.where(found, which, 0))
        np.testing.assert_allclose(distances, wanted, rtol=1e-14)


@pytest.mark.parametrize("cells", [1, 7, 10**6])
def test_however_many_are_compared_at_once(monkeypatch: pytest.MonkeyPatch, cells: int) -> None:
    rng = np.random.default_rng(5)
    points, places = rng.normal(size=(30, 3)), rng.normal(size=(41, 3))
    wanted = NearestPoints(points).query(places, 1.0)
    monkeypatch.setattr(rigid_search, "CELLS", cells)
    for one, other in zip(NearestPoints(points).query(places, 1.0), wanted, strict=True):
        np.testing.assert_array_equal(one, other)


def test_far_from_the_origin_the_one_that_is_taken_is_as_near_as_the_nearest() -> None:
    rng = np.random.default_rng(6)
    points, places = rng.normal(scale=0.3, size=(3000, 3)) + 500.0, rng.normal(scale=0.3, size=(400, 3)) + 500.0
    distances, nearest = NearestPoints(points).query(places, np.inf)
    np.testing.assert_allclose(distances, cKDTree(points).query(places)[0], atol=ROUNDING)
    np.testing.assert_allclose(distances, np.linalg.norm(points[nearest] - places, axis=1), rtol=1e-14)


def test_the_first_of_equal_points_is_taken_and_nothing_beyond_the_reach() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    distances, nearest = NearestPoints(points).query(np.array([[1.0, 0.5], [9.0, 0.0]]), 0.6)
    np.testing.assert_array_equal(distances, [0.5, np.inf])
    np.testing.assert_array_equal(nearest, [1, 0])
