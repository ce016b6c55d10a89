"""Dense Cholesky factors, by LAPACK directly: SciPy's checks take longer than a fit's small matrices do."""

import numpy as np
from numpy.linalg import LinAlgError
from scipy.linalg import lapack

from breastrig.core.arrays import Array


def cholesky(matrix: Array) -> Array:
    """The lower factor L of a symmetric positive definite (N, N) matrix L Lᵀ; LinAlgError for any other.

    What stands above the diagonal is neither read nor cleared.
    """
    if not len(matrix):
        return matrix
    factor, info = lapack.dpotrf(matrix, lower=1, clean=0)
    if info:
        raise LinAlgError("The matrix is not positive definite.")
    return np.asarray(factor)


def solve_lower(factor: Array, right: Array, transposed: bool = False) -> Array:
    """L⁻¹ right or L⁻ᵀ right, for (N, N) L of which the lower half is read, and (N,) or (N, M) right."""
    if not len(factor):
        return right
    return np.asarray(lapack.dtrtrs(factor, right, lower=1, trans=int(transposed))[0])
