"""Vectors of length one."""

import numpy as np

from breastrig.core.arrays import Array


def unit_vectors(vectors: Array) -> Array:
    """(M, D) the rows scaled to length one; those without a direction stay as short as they are."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))
