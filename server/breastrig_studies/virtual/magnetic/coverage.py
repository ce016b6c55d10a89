"""The share of every voxel that lies inside a closed surface."""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_crosses

TOGETHER = 2_000_000  # columns times triangles at once
FLAT = 1e-12
ASIDE = np.array([3.1e-7, 2.7e-7])  # of a column: none lies exactly on an edge, which would count twice


def coverage(
    vertices: Array, faces: Integers, low: Array, steps: Array, shape: tuple[int, int, int], fine: int = 2
) -> Array:
    """(I, J, K) 0 to 1, float32, of voxels whose first middle is `low` and whose edges are `steps`, axes parallel.

    Exact along the second axis, by `fine` x `fine` columns a voxel; what lies inside twice counts once.
    """
    at = (vertices - low) / steps
    columns = at[:, [0, 2]] * fine + 0.5 * (fine - 1) + ASIDE  # whole numbers at the columns
    wide, deep = fine * shape[0], fine * shape[2]
    side = -np.sign(face_crosses(vertices, faces)[:, 1])
    corners, depths = columns[faces], at[:, 1][faces]
    first = np.clip(np.ceil(corners.min(axis=1)), 0, [wide, deep]).astype(np.int64)
    last = np.clip(np.floor(corners.max(axis=1)), -1, [wide - 1, deep - 1]).astype(np.int64)
    counts = np.prod(np.maximum(last - first + 1, 0), axis=1)
    edges = np.zeros(shape[0] * (shape[1] + 2) * shape[2], np.float32)
    chosen = np.flatnonzero(counts)
    for part in np.split(chosen, np.flatnonzero(np.diff(np.cumsum(counts[chosen]) // TOGETHER)) + 1):
        repeated = np.repeat(part, counts[part])
        within = np.arange(len(repeated)) - np.repeat(np.cumsum(counts[part]) - counts[part], counts[part])
        across = last[repeated, 1] - first[repeated, 1] + 1
        cell = first[repeated] + np.stack([within // across, within % across], axis=1)
        a, b, c = (corners[repeated, k] for k in range(3))
        u, v, w = b - a, c - a, cell - a
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        there = np.abs(area) > FLAT
        area = np.where(there, area, 1.0)
        s, t = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / area, (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / area
        there &= (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
        where, cell, s, t = repeated[there], cell[there] // fine, s[there], t[there]
        depth = depths[where, 0] + s * (depths[where, 1] - depths[where, 0]) + t * (depths[where, 2] - depths[where, 0])
        depth = np.clip(depth, -0.5, shape[1] - 0.5) + 0.5
        layer = np.floor(depth).astype(np.int64)
        part_inside = layer + 1 - depth
        flat = (cell[:, 0] * (shape[1] + 2) + layer) * shape[2] + cell[:, 1]
        np.add.at(edges, flat, side[where] * part_inside)
        np.add.at(edges, flat + shape[2], side[where] * (1.0 - part_inside))
    inside = np.cumsum(edges.reshape(shape[0], shape[1] + 2, shape[2]), axis=1)[:, : shape[1]]
    return np.clip(inside / np.float32(fine * fine), 0.0, 1.0)
