"""Means of a picture under kernels and medians, against SciPy's own."""

import numpy as np
import pytest
from scipy.ndimage import median_filter

from breastrig.colour.features.areola import _median, _Sums


def test_means_under_kernels_are_those_of_convolution(rng: np.random.Generator) -> None:
    from scipy.signal import fftconvolve  # slow to load, and every worker reads this file

    picture, known = rng.random((40, 33)), rng.random((40, 33)) < 0.7
    kernels = [rng.random(size) for size in ((7, 7), (8, 8), (5, 8), (1, 1))]
    sums = _Sums(picture, known, kernels)
    for kernel in kernels:
        weight = fftconvolve(known.astype(float), kernel[::-1, ::-1], mode="same")
        total = fftconvolve(np.where(known, picture, 0.0), kernel[::-1, ::-1], mode="same")
        mean, share = sums.mean(kernel)
        np.testing.assert_allclose(mean, total / np.maximum(weight, 0.5), atol=1e-12)
        np.testing.assert_allclose(share, weight / kernel.sum(), atol=1e-12)


@pytest.mark.parametrize("size", [3, 5])
def test_medians_are_those_of_scipy(rng: np.random.Generator, size: int) -> None:
    pictures = rng.normal(size=(31, 27, 3))
    np.testing.assert_array_equal(_median(pictures, size), median_filter(pictures, size=(size, size, 1)))
