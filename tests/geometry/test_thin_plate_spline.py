"""The thin-plate spline, against SciPy's."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from breastrig.geometry.thin_plate_spline import ThinPlateSpline


@pytest.mark.parametrize("smoothing", [0.0, 1e-5, 0.1])
def test_it_is_scipys(smoothing: float) -> None:
    rng = np.random.default_rng(11)
    points, values = rng.uniform(-1.0, 3.0, (80, 2)) * [1.0, 0.2], rng.normal(size=80)
    asked = np.concatenate([points, rng.uniform(-2.0, 4.0, (50, 2))])
    library = RBFInterpolator(points, values, kernel="thin_plate_spline", smoothing=smoothing)
    np.testing.assert_allclose(ThinPlateSpline(points, values, smoothing)(asked), library(asked), atol=1e-7)


def test_it_goes_through_the_values_and_keeps_a_plane() -> None:
    points = np.random.default_rng(2).normal(size=(20, 2))
    plane = 2.0 + points @ [0.5, -1.0]
    np.testing.assert_allclose(ThinPlateSpline(points, plane)(10.0 * points), 2.0 + 10.0 * points @ [0.5, -1.0])
    values = np.sin(points).sum(axis=1)
    np.testing.assert_allclose(ThinPlateSpline(points, values)(points), values, atol=1e-12)


def test_points_on_one_line_are_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        ThinPlateSpline(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.zeros(3))
