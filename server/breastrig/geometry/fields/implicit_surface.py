"""A surface through oriented points: where the mean height over their tangent planes is zero.

The height of a place is the Gaussian mean of its heights over the planes of the points near it (Hoppe and others, 1992;
the weights make it the moving least squares surface of order zero of Shen and others, 2004).  It is asked for on a
grid, only near points, and marching cubes finds the zero.  Nothing is made farther than `reach` from a point, so no gap
is bridged that is wider than twice that; and where points lie to one side only, nothing is continued beyond them.
Triangles between the points themselves would follow a depth camera's noise, a millimetre at a spacing of two.
"""

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers

NEAREST = 12  # points that a height is the mean of
AROUND, BORDER = 48, 0.5  # points around a place of which the middle is asked, and how far it may be
CHUNK = 200_000  # places asked for at a time: 60 MB


def implicit_surface(points: Array, normals: Array, width: float, cell: float, reach: float) -> tuple[Array, Integers]:
    """(V, 3) m vertices and (F, 3) faces, seen from the side of the normals counter-clockwise.

    points (N, 3) m, normals (N, 3) unit; `width` of the Gaussian, `cell` of the grid and `reach` in m.
    """
    from skimage.measure import marching_cubes  # 0.3 s to load, and hardly any scan is a cloud of points

    margin = reach + 2.0 * cell
    low = points.min(axis=0) - margin
    shape = tuple(1 + np.ceil((np.ptp(points, axis=0) + 2 * margin) / cell).astype(np.int64))
    near = _near_cells(points, low, cell, reach, shape)
    tree = cKDTree(points)
    heights = np.zeros(shape, np.float32)
    known = np.zeros(shape, np.bool_)
    for start in range(0, len(near), CHUNK):
        part = near[start : start + CHUNK]
        places = low + cell * np.stack(np.unravel_index(part, shape), axis=1)
        distances, who = tree.query(places, k=min(NEAREST, len(points)), distance_upper_bound=margin)
        weights = np.where(np.isfinite(distances), np.exp(-0.5 * (distances / width) ** 2), 0.0)
        who = np.where(np.isfinite(distances), who, 0)
        total = weights.sum(axis=1)
        along = np.einsum("nki,nki->nk", places[:, None] - points[who], normals[who])
        heights.ravel()[part] = (weights * along).sum(axis=1) / np.maximum(total, 1e-300)
        known.ravel()[part] = total > 0.0
    cubes = np.zeros(shape, np.bool_)  # whose eight corners are all known
    whole = known[1:] & known[:-1]
    whole = whole[:, 1:] & whole[:, :-1]
    cubes[1:, 1:, 1:] = whole[:, :, 1:] & whole[:, :, :-1]
    below, above = heights[known].min(initial=0.0), heights[known].max(initial=0.0)
    if not cubes.any() or not below < 0.0 < above:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    try:
        vertices, faces, _, _ = marching_cubes(heights, 0.0, spacing=(cell,) * 3, mask=cubes, allow_degenerate=False)
    except (ValueError, RuntimeError):  # there is no zero where all corners are known
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    vertices = vertices.astype(np.float64) + low
    kept = _among_points(tree, vertices, reach, max(reach, 2.0 * width))
    faces = faces[kept[faces].all(axis=1)].astype(np.int64)
    used, inverse = np.unique(faces, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3)


def _among_points(tree: cKDTree, vertices: Array, reach: float, around: float) -> Booleans:
    """(V,) within `reach` of a point and not beyond the border of all of them.

    At a straight border the mean of the points within `around` of a place is 0.42 of that away; beyond the border it is
    farther.
    """
    found = tree.query(vertices, k=AROUND, distance_upper_bound=around)
    distances, who = np.asarray(found[0]), np.asarray(found[1])
    there = np.isfinite(distances)
    places = np.where(there[:, :, None], tree.data[np.where(there, who, 0)], 0.0)
    middle = places.sum(axis=1) / np.maximum(there.sum(axis=1), 1)[:, None]
    aside = np.linalg.norm(middle - vertices, axis=1)
    return np.asarray((distances[:, 0] <= reach) & (aside <= BORDER * around))


def _near_cells(points: Array, low: Array, cell: float, reach: float, shape: tuple[int, ...]) -> Integers:
    """Flat numbers of the grid's places within about `reach` of a point: those of the points' cells, widened."""
    own = np.unique(np.ravel_multi_index(tuple(np.round((points - low) / cell).astype(np.int64).T), shape))
    steps = int(np.ceil(reach / cell)) + 1
    ball = np.stack(np.meshgrid(*3 * [np.arange(-steps, steps + 1)], indexing="ij"), axis=-1).reshape(-1, 3)
    ball = ball[np.linalg.norm(ball, axis=1) * cell <= reach + 1.5 * cell]
    filled = np.zeros(int(np.prod(shape)), np.bool_)
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    for step in ball @ strides:  # a border of `reach` around all points keeps every step inside
        filled[np.clip(own + step, 0, len(filled) - 1)] = True
    return np.flatnonzero(filled)
