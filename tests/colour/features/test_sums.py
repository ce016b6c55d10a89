"""Means of a picture under kernels, against SciPy's own convolution."""

import numpy as np
from scipy.signal import fftconvolve

from breastrig.colour.features.areola import _Sums


def test_means_under_kernels_are_those_of_convolution(rng: np.random.Generator) -> None:
    picture, known = rng.random((40, 33)), rng.random((40, 33)) < 0.7
    kernels = [rng.random(size) for size in ((7, 7), (8, 8), (5, 8), (1, 1))]
    sums = _Sums(picture, known, kernels)
    for kernel in kernels:
        weight = fftconvolve(known.astype(float), kernel[::-1, ::-1], mode="same")
        total = fftconvolve(np.where(known, picture, 0.0), kernel[::-1, ::-1], mode="same")
        mean, share = sums.mean(kernel)
        np.testing.assert_allclose(mean, total / np.maximum(weight, 0.5), atol=1e-12)
        np.testing.assert_allclose(share, weight / kernel.sum(), atol=1e-12)
