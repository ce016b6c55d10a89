"""The part of a triangle mesh where a function of its vertices is above a level, cut through the triangles.

The function is linear on each triangle, so the cut is exact for it.  Moving the level moves the border of the part.
"""

import numpy as np

from breastrig.core.arrays import Array, Integers


def crossings(vertices: Array, faces: Integers, values: Array, level: float) -> Array:
    """(M, 3) points of the edges where the (V,) values pass the level; each edge once, ordered by its ends."""
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    edges = edges[(values[edges[:, 0]] > level) != (values[edges[:, 1]] > level)]
    return _cut(vertices, values, level, edges)


def part_above(vertices: Array, faces: Integers, values: Array, level: float) -> tuple[Array, Integers]:
    """((W, 3) vertices, (G, 3) triangles in their old direction) of the part where the (V,) values are above it."""
    above = values > level
    count = above[faces].sum(axis=1)
    triangles = [faces[count == 3]]
    mixed = faces[(count == 1) | (count == 2)]
    odd = np.argmax(above[mixed] == (above[mixed].sum(axis=1) == 1)[:, None], axis=1)  # the corner alone on its side
    turned = np.stack([mixed[np.arange(len(mixed)), (odd + k) % 3] for k in range(3)], axis=1)
    edges = np.concatenate([turned[:, [0, 1]], turned[:, [0, 2]]])
    unique, index = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    first, second = (len(vertices) + index.ravel()).reshape(2, -1)
    alone, b, c = turned.T
    tip = above[alone]
    triangles.append(np.stack([alone, first, second], axis=1)[tip])
    triangles.append(np.stack([first, b, c], axis=1)[~tip])
    triangles.append(np.stack([first, c, second], axis=1)[~tip])
    points = np.concatenate([vertices, _cut(vertices, values, level, unique)])
    used, renumbered = np.unique(np.concatenate(triangles), return_inverse=True)
    return points[used], np.asarray(renumbered.reshape(-1, 3), dtype=np.int64)


def _cut(vertices: Array, values: Array, level: float, edges: Integers) -> Array:
    a, b = edges.T
    share = ((level - values[a]) / np.where(edges[:, 0] == edges[:, 1], 1.0, values[b] - values[a]))[:, None]
    return np.asarray((1.0 - share) * vertices[a] + share * vertices[b])
