"""Differential operators on a triangle mesh: cotangent Laplacian, smoothing, thin-plate fill, volume.

Meyer et al. 2003 for the cotangents, Botsch and Kobbelt 2004 for the bi-Laplacian fill.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from steps.source import Array, Booleans, Integers


def laplacian(vertices: Array, triangles: Integers) -> tuple[sparse.csr_matrix, Array]:
    """((V, V) positive semi-definite cotangent matrix, (V,) m² area of each vertex)."""
    count = len(vertices)
    rows, columns, values = [], [], []
    area = np.zeros(count)
    for i in range(3):
        a, b, c = triangles[:, i], triangles[:, (i + 1) % 3], triangles[:, (i + 2) % 3]
        u, w = vertices[b] - vertices[a], vertices[c] - vertices[a]
        twice = np.linalg.norm(np.cross(u, w), axis=1)
        half_cot = 0.5 * np.clip((u * w).sum(1) / twice, -5.0, 5.0)
        rows += [b, c]
        columns += [c, b]
        values += [half_cot, half_cot]
        np.add.at(area, a, twice / 6.0)
    weights = sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (count, count)
    )
    return (sparse.diags(np.asarray(weights.sum(axis=1)).ravel()) - weights).tocsr(), area


def smoothed(field: Array, stiffness: sparse.csr_matrix, area: Array, length: float) -> Array:
    """A (V, ...) field after heat has spread over `length` (m)."""
    matrix = (sparse.diags(area) + length**2 * stiffness).tocsc()
    flat = field.reshape(len(area), -1)
    solved = spsolve(matrix, area[:, None] * flat)
    return np.asarray(solved).reshape(field.shape)


def thin_plate(field: Array, inside: Booleans, stiffness: sparse.csr_matrix, area: Array) -> Array:
    """A (V, C) field with its `inside` part replaced by the smoothest continuation of the rest."""
    bilaplacian = (stiffness @ sparse.diags(1.0 / area) @ stiffness).tocsr()
    free, fixed = np.flatnonzero(inside), np.flatnonzero(~inside)
    system = bilaplacian[free]
    result = field.copy()
    result[free] = np.asarray(spsolve(system[:, free].tocsc(), -(system[:, fixed] @ field[fixed]))).reshape(
        len(free), -1
    )
    return result


def volume_gradient(vertices: Array, triangles: Integers) -> Array:
    """(V, 3) m²: the volume that a displacement adds is the sum of its products with this."""
    result = np.zeros_like(vertices)
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 6.0
    for i in range(3):
        np.add.at(result, triangles[:, i], cross)
    return result
