"""Sums of a picture under a kernel, against SciPy's own."""

import numpy as np
import pytest
from scipy.signal import fftconvolve

from breastrig.colour.features.areola import _correlated


@pytest.mark.parametrize("size", [(7, 7), (8, 8), (5, 8), (1, 1)])
def test_sums_under_a_kernel_are_scipys(size: tuple[int, int], rng: np.random.Generator) -> None:
    picture, kernel = rng.random((40, 33)), rng.random(size)
    expected = fftconvolve(picture, kernel[::-1, ::-1], mode="same")
    np.testing.assert_allclose(_correlated(picture, kernel), expected, atol=1e-12)
