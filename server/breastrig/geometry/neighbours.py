"""The mean of a mesh vertex's neighbours, for all vertices at once."""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from breastrig.core.arrays import Integers


def neighbours(triangles: Integers, count: int) -> csr_array:
    """(N, N) rows that average over the neighbours of each vertex; a vertex without triangles has an empty one."""
    i, j = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    both = coo_array((np.ones(2 * len(i)), (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(count, count))
    links = csr_array(both)
    links.data[:] = 1.0
    return csr_array(diags_array(1.0 / np.maximum(links.sum(axis=1), 1.0)) @ links)
