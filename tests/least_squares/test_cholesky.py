"""Cholesky factors are SciPy's."""

import numpy as np
import pytest
import scipy.linalg
from numpy.linalg import LinAlgError

from breastrig.least_squares.quadratic_program import cholesky, solve_lower


def test_factors_are_those_of_scipy() -> None:
    half = np.random.default_rng(3).normal(size=(30, 30))
    matrix, right = half @ half.T + np.eye(30), np.arange(30.0)
    factor, public = cholesky(matrix), scipy.linalg.cholesky(matrix, lower=True)
    np.testing.assert_array_equal(np.tril(factor), public)
    for transposed in (False, True):
        wanted = scipy.linalg.solve_triangular(public, right, lower=True, trans=int(transposed))
        np.testing.assert_allclose(solve_lower(factor, right, transposed), wanted, rtol=1e-12)


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    with pytest.raises(LinAlgError, match="not positive definite"):
        cholesky(np.diag([1.0, -1.0]))
    assert cholesky(np.zeros((0, 0))).shape == (0, 0)
    assert solve_lower(np.zeros((0, 0)), np.zeros(0)).shape == (0,)
