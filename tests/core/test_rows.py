"""Reductions of short rows give NumPy's own bits."""

import numpy as np
import pytest

from breastrig.core.arrays import all_in_row, any_in_row, lengths


@pytest.mark.parametrize("size", [0, 1, 7, 5000])
@pytest.mark.parametrize("axes", [2, 3])
def test_rows_are_reduced_to_the_same_bits(size: int, axes: int) -> None:
    random = np.random.default_rng(size)
    rows = random.standard_normal((size, axes)) * 10.0 ** random.uniform(-12.0, 6.0, (size, 1))
    rows[::5] = np.nan
    np.testing.assert_array_equal(lengths(rows), np.linalg.norm(rows, axis=1))
    near = np.abs(rows) < 1e-3
    np.testing.assert_array_equal(all_in_row(near), near.all(axis=1))
    np.testing.assert_array_equal(any_in_row(near), near.any(axis=1))
