"""Polylines in space."""

import numpy as np

from breastrig.core.arrays import Array


def resampled(points: Array, spacing: float, closed: bool) -> Array:
    """(N, D) points evenly along a (M, D) polyline whose first three columns are positions (m).

    Ends are kept; a closed line is not repeated at its end; further columns are carried along linearly.
    """
    line = np.concatenate([points, points[:1]]) if closed else points
    steps = np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if length[-1] == 0.0:
        return points[:1].copy()
    count = max(int(np.ceil(length[-1] / spacing)), 3 if closed else 1)
    at = np.linspace(0.0, length[-1], count + 1)[: count if closed else count + 1]
    return np.column_stack([np.interp(at, length, line[:, column]) for column in range(line.shape[1])])
