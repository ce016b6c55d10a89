"""A smooth surface over scattered points of a plane: the thin-plate spline with a linear part.

f(x) = Σ_i w_i φ(|x − x_i|) + a + b·x with φ(r) = r² log r, and w orthogonal to all linear functions; it bends least
among all surfaces that are as near to the values (Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev
spaces, 1977).  SciPy's RBFInterpolator computes the same and takes longer to load than a report to make.
"""

import numpy as np

from breastrig.core.arrays import Array


class ThinPlateSpline:
    """Through N values, up to the smoothing; LinAlgError when the points lie on one line."""

    def __init__(self, points: Array, values: Array, smoothing: float = 0.0) -> None:
        """points: (N, 2), values: (N,); `smoothing` is added to the diagonal, 0 goes through the values."""
        low, high = points.min(axis=0), points.max(axis=0)
        self._points, self._middle = points, 0.5 * (low + high)
        self._reach = np.where(high > low, 0.5 * (high - low), 1.0)
        linear = self._linear(points)
        count, more = linear.shape
        system = np.zeros((count + more, count + more))
        system[:count, :count] = _bend(points, points) + smoothing * np.eye(count)
        system[:count, count:], system[count:, :count] = linear, linear.T
        self._weights = np.linalg.solve(system, np.concatenate([values, np.zeros(more)]))

    def _linear(self, points: Array) -> Array:
        """(M, 3) of (M, 2)"""
        return np.column_stack([np.ones(len(points)), (points - self._middle) / self._reach])

    def __call__(self, points: Array) -> Array:
        """(M,) at (M, 2)"""
        return np.asarray(np.hstack([_bend(points, self._points), self._linear(points)]) @ self._weights)


def _bend(points: Array, centres: Array) -> Array:
    """(M, N) φ of the distances."""
    apart = points[:, None] - centres
    squares = np.einsum("mni,mni->mn", apart, apart)
    return np.asarray(0.5 * squares * np.log(np.where(squares > 0.0, squares, 1.0)))
