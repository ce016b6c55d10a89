"""Depth images become one surface, as scanning programs do it.

A grid of voxels keeps the mean signed distance to what the views saw, cut off at a few voxels (Curless and
Levoy 1996); the surface is where it changes its sign, drawn by naive surface nets (Gibson 1998): one vertex
for each crossed cell, one quad for each crossed edge.  Against marching cubes: no table, and no thin triangles.
Where nothing was seen there is no distance, so holes and borders come by themselves.
"""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import binary_dilation, generate_binary_structure
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from breastrig.core.arrays import Array, Integers
from breastrig_studies.virtual.depth_camera import DepthImage

TRUNCATION = 3.0  # voxels; distances are cut off here
ENOUGH = 1.3  # views that must have seen a voxel, obliquely seen ones count less


def fuse(
    images: Sequence[DepthImage], low: Array, high: Array, voxel: float, enough: float = ENOUGH
) -> tuple[Array, Integers]:
    """((V, 3) m, (F, 3)) the surface inside the box from `low` to `high` (m), on a grid of `voxel` (m)."""
    size = np.ceil((high - low) / voxel).astype(np.int64) + 1
    total, weight = _distances(images, low, size, voxel)
    vertices, faces = surface_nets(total, weight >= enough)
    return low + voxel * vertices, faces


def without_small_pieces(vertices: Array, faces: Integers, smallest: int) -> tuple[Array, Integers, Integers]:
    """((V', 3), (F', 3), (V',) kept vertices) without pieces of fewer than `smallest` triangles and free vertices."""
    size = len(vertices)
    ends = (faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())
    _, label = connected_components(csr_array((np.ones(2 * len(faces)), ends), shape=(size, size)), directed=False)
    piece = label[faces[:, 0]]
    kept = faces[np.bincount(piece, minlength=size)[piece] >= smallest]
    used, numbered = np.unique(kept, return_inverse=True)
    return vertices[used], numbered.reshape(-1, 3).astype(np.int64), used.astype(np.int64)


def _distances(images: Sequence[DepthImage], low: Array, size: Integers, voxel: float) -> tuple[Array, Array]:
    """(X, Y, Z) mean signed distance in voxels, positive outside, and how often it was seen."""
    near = np.zeros(tuple(size), dtype=np.bool_)
    for image in images:
        cell = np.rint((image.points() - low) / voxel).astype(np.int64)
        near[tuple(cell[((cell >= 0) & (cell < size)).all(axis=1)].T)] = True
    near = binary_dilation(near, generate_binary_structure(3, 3), iterations=int(TRUNCATION) + 1)
    index = np.flatnonzero(near)
    places = low + voxel * np.stack(np.unravel_index(index, near.shape), axis=1)
    sums, weights = np.zeros(len(index)), np.zeros(len(index))
    for image in images:
        camera = image.camera
        at = image.view.in_camera(places)
        depth = np.maximum(at[:, 2], 1e-3)
        column = np.floor(at[:, 0] / depth * camera.focal_length + camera.width / 2).astype(np.int64)
        row = np.floor(at[:, 1] / depth * camera.focal_length + camera.height / 2).astype(np.int64)
        inside = (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height) & (at[:, 2] > 0.1)
        row, column = np.where(inside, row, 0), np.where(inside, column, 0)
        slant = _slant(image)
        gap = (image.depth[row, column] - at[:, 2]) * slant[row, column] / voxel  # along the normal, about
        counted = inside & (gap > -TRUNCATION)  # NaN compares false
        share = slant[row[counted], column[counted]]
        sums[counted] += share * np.minimum(gap[counted], TRUNCATION)
        weights[counted] += share
    total, weight = np.zeros(near.shape), np.zeros(near.shape)
    total.flat[index] = sums / np.maximum(weights, 1e-9)
    weight.flat[index] = weights
    return total, weight


def _slant(image: DepthImage) -> Array:
    """(height, width) cosine between the line of sight and the surface, from the slope of the depth."""
    depth = np.where(np.isfinite(image.depth), image.depth, np.nan)
    down, across = np.gradient(depth)
    pixel = depth / image.camera.focal_length
    with np.errstate(invalid="ignore"):
        slope = np.hypot(down, across) / pixel
    return np.asarray(np.clip(1.0 / np.sqrt(1.0 + np.nan_to_num(slope, nan=1.0) ** 2), 0.25, 1.0))


def surface_nets(total: Array, known: np.ndarray) -> tuple[Array, Integers]:
    """((V, 3) in voxels, (F, 3)) the zero surface, only in cells whose eight corners are known."""
    shape = np.array(total.shape)
    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]

    def shifted(field: np.ndarray, corner: tuple[int, int, int]) -> np.ndarray:
        return field[tuple(slice(c, n - 1 + c) for c, n in zip(corner, shape, strict=True))]

    inside = total < 0
    complete = np.logical_and.reduce([shifted(known, corner) for corner in corners])
    count = sum(shifted(inside, corner).astype(np.int8) for corner in corners)
    crossed = complete & (count > 0) & (count < 8)
    cells = np.argwhere(crossed)
    place, uses = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for a, b in ((a, b) for a in corners for b in corners if sum(b) - sum(a) == 1 and all(np.subtract(b, a) >= 0)):
        value_a, value_b = total[tuple((cells + a).T)], total[tuple((cells + b).T)]
        cut = (value_a < 0) != (value_b < 0)
        share = np.where(cut, value_a / np.where(cut, value_a - value_b, 1.0), 0.0)[:, None]
        place += cut[:, None] * ((1.0 - share) * a + share * np.array(b))
        uses += cut
    vertices = cells + place / uses[:, None]
    number = np.full(tuple(shape - 1), -1, dtype=np.int64)
    number[crossed] = np.arange(len(cells))
    quads = [_quads(inside, number, axis) for axis in range(3)]
    return vertices, _triangles(vertices, np.concatenate(quads))


def _quads(inside: np.ndarray, number: Integers, axis: int) -> Integers:
    """(Q, 4) one quad around each grid edge along `axis` that crosses the surface, seen from outside."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    lower = np.moveaxis(inside, (axis, u, v), (0, 1, 2))
    cells = np.moveaxis(number, (axis, u, v), (0, 1, 2))
    a, b = lower[:-1, 1:-1, 1:-1], lower[1:, 1:-1, 1:-1]
    around = np.stack([cells[:, :-1, :-1], cells[:, 1:, :-1], cells[:, 1:, 1:], cells[:, :-1, 1:]], axis=-1)
    valid = (a != b) & (around >= 0).all(axis=-1)
    outwards = a[valid]  # inside below, outside above: the surface looks along the axis
    quads = around[valid]
    return np.asarray(np.where(outwards[:, None], quads, quads[:, ::-1]))


def _triangles(vertices: Array, quads: Integers) -> Integers:
    """(2Q, 3) quads cut along their shorter diagonal."""
    first = np.linalg.norm(vertices[quads[:, 0]] - vertices[quads[:, 2]], axis=1)
    second = np.linalg.norm(vertices[quads[:, 1]] - vertices[quads[:, 3]], axis=1)
    turned = np.where((first <= second)[:, None], quads, np.roll(quads, 1, axis=1))
    return np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])
