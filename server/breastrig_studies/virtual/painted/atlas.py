"""A texture atlas for a simulated scan: charts, their places in one square picture, and which triangle owns a texel.

A chart is a connected part of the skin that looks about the same way, projected along the axis it looks along; what
lies behind another part of its chart becomes a chart of its own.  Real programs unwrap better, but seams, gutters
and the loss at oblique skin are of the same kind.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.half_edges import neighbours
from breastrig.geometry.normals import face_normals, vertex_normals

SMOOTHING = 12  # rounds of averaging the normals over neighbours, so that noise makes no charts
BUCKET = 0.004  # m, of the search for skin behind skin
BEHIND = 0.015  # m; deeper than this behind the foremost skin of its bucket
GUTTER = 3  # texels between charts, filled with the nearest colour
TRIES = 14  # halvings of the texel size
CANDIDATES = 4_000_000  # texels looked at together


@dataclass(frozen=True, eq=False)
class Atlas:
    """The atlas of F triangles, on `side` x `side` texels; row 0 is the upper edge, as in a picture."""

    side: int
    texel: float  # m on skin that faces its chart's axis
    charts: int
    places: Array  # (F, 3, 2) column and row of each triangle's corners, in texels
    owners: Integers  # (side, side) the triangle, -1 in the gutter
    weights: Array  # (N, 3) barycentric, of the owned texels in their order

    @property
    def uv(self) -> Array:
        """(F, 3, 2) as OBJ has it: from the lower left corner, 0 to 1."""
        return np.stack([self.places[..., 0] / self.side, 1.0 - self.places[..., 1] / self.side], axis=-1)

    @property
    def owned(self) -> Integers:
        """(N,) flat indices of the texels that a triangle owns."""
        return np.flatnonzero(self.owners.ravel() >= 0)

    def picture(self, values: Array) -> Array:
        """(side, side, C) from (N, C) values of the owned texels; gutters take the nearest, far from skin is black."""
        flat = np.zeros((self.side**2, values.shape[1]))
        flat[self.owned] = values
        empty = self.owners < 0
        distance, nearest = distance_transform_edt(empty, return_indices=True)
        rows, columns = nearest
        full: Array = flat.reshape(self.side, self.side, -1)[rows, columns]
        full[distance > 2 * GUTTER] = 0.0
        return full


def make_atlas(vertices: Array, faces: Integers, side: int) -> Atlas:
    """The atlas of a scan of (V, 3) m vertices and (F, 3) triangles."""
    axis = _axes(vertices, faces)
    chart = _components(faces, axis, len(vertices))
    flat = _projected(vertices, faces, axis)
    hidden = _behind(vertices, faces, axis, chart, flat)
    chart = _components(faces, axis + 6 * hidden, len(vertices))
    count = int(chart.max()) + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    for corner in range(3):
        np.minimum.at(low, chart, flat[:, corner])
        np.maximum.at(high, chart, flat[:, corner])
    texel, corners = _packed(high - low, side)
    places = (flat - low[chart][:, None]) / texel + corners[chart][:, None] + GUTTER
    owners, weights = _owners(places, side)
    return Atlas(side, texel, count, places, owners, weights)


def _axes(vertices: Array, faces: Integers) -> Integers:
    """(F,) 0 to 5: the axis and sign that a triangle looks along."""
    normals = vertex_normals(vertices, faces)
    mean = neighbours(faces, len(vertices))
    for _ in range(SMOOTHING):
        normals = 0.5 * normals + 0.5 * (mean @ normals)
    looks = normals[faces].mean(axis=1)
    own = face_normals(vertices, faces)
    looks = np.where((np.einsum("fi,fi->f", looks, own) > 0.2)[:, None], looks, own)
    main = np.abs(looks).argmax(axis=1)
    return np.asarray(2 * main + (looks[np.arange(len(faces)), main] < 0))


def _components(faces: Integers, label: Integers, count: int) -> Integers:
    """(F,) number of the connected part of triangles with one label."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys = (edges[:, 0] * count + edges[:, 1]) * 12 + np.repeat(label, 3)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(np.diff(keys[order]) == 0)
    owner = np.repeat(np.arange(len(faces)), 3)[order]
    links = coo_array((np.ones(len(same)), (owner[same], owner[same + 1])), shape=(len(faces), len(faces)))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _projected(vertices: Array, faces: Integers, axis: Integers) -> Array:
    """(F, 3, 2) m: the corners in the plane that the triangle's axis looks at."""
    others = np.array([[1, 2], [0, 2], [0, 1]])[axis // 2]  # (F, 2)
    return np.asarray(np.take_along_axis(vertices[faces], others[:, None, :].repeat(3, axis=1), axis=2))


def _behind(vertices: Array, faces: Integers, axis: Integers, chart: Integers, flat: Array) -> Booleans:
    """(F,) which triangles lie behind others of their chart."""
    middle = vertices[faces].mean(axis=1)
    depth = np.where(axis % 2 == 0, 1.0, -1.0) * middle[np.arange(len(faces)), axis // 2]
    cell = np.floor(flat.mean(axis=1) / BUCKET).astype(np.int64)
    _, bucket = np.unique(np.column_stack([chart, cell]), axis=0, return_inverse=True)
    bucket = bucket.ravel()
    front = np.full(int(bucket.max()) + 1, -np.inf)
    np.maximum.at(front, bucket, depth)
    return np.asarray(depth < front[bucket] - BEHIND)


def _packed(sizes: Array, side: int) -> tuple[float, Array]:
    """(texel in m, (C, 2) texels of each chart's corner): rows of charts of falling height, as large as fits."""
    order = np.argsort(-sizes[:, 1], kind="stable")
    fine, coarse = 0.0, float(sizes.max()) / (0.2 * side) + np.sqrt(sizes.prod(axis=1).sum()) * 4.0 / side
    best = _rows(sizes, coarse, side, order)
    assert best is not None, "more charts than the picture has room for"
    for _ in range(TRIES):
        texel = 0.5 * (fine + coarse)
        found = _rows(sizes, texel, side, order)
        if found is None:
            fine = texel
        else:
            coarse, best = texel, found
    return coarse, best


def _rows(sizes: Array, texel: float, side: int, order: Integers) -> Array | None:
    boxes = np.ceil(sizes / texel).astype(np.int64) + 2 * GUTTER + 1
    corners, x, y, height = np.zeros(sizes.shape), 0, 0, 0
    for index in order.tolist():
        wide, high = boxes[index].tolist()
        if x + wide > side:
            x, y, height = 0, y + height, 0
        if x + wide > side or y + high > side:
            return None
        corners[index] = x, y
        x, height = x + wide, max(height, high)
    return corners


def _owners(places: Array, side: int) -> tuple[Integers, Array]:
    """((side, side) triangles or -1, (N, 3) weights of the owned texels) by the texels' middles."""
    low = np.maximum(np.floor(places.min(axis=1) - 0.5).astype(np.int64), 0)
    high = np.minimum(np.ceil(places.max(axis=1) + 0.5).astype(np.int64), side)
    wide, tall = (high - low).T
    counts = wide * tall
    owners = np.full(side * side, -1, dtype=np.int64)
    weights = np.zeros((side * side, 3))
    ends = np.cumsum(counts)
    first = 0
    while first < len(places):
        last = int(np.searchsorted(ends, (ends[first - 1] if first else 0) + CANDIDATES)) + 1
        part = np.arange(first, min(last, len(places)))
        face = np.repeat(part, counts[part])
        step = np.arange(len(face)) - np.repeat(np.cumsum(counts[part]) - counts[part], counts[part])
        column, row = low[face, 0] + step % wide[face], low[face, 1] + step // wide[face]
        inside = _weights(places[face], np.stack([column, row], axis=1) + 0.5)
        good = inside.min(axis=1) > -1e-9
        at = (row * side + column)[good]
        owners[at], weights[at] = face[good], inside[good]
        first = int(part[-1]) + 1
    return owners.reshape(side, side), weights[owners >= 0]


def _weights(corners: Array, points: Array) -> Array:
    """(M, 3) barycentric coordinates of (M, 2) points in (M, 3, 2) triangles; -1 where there is no area."""
    a, b, c = (corners[:, k] for k in range(3))

    def cross(u: Array, v: Array) -> Any:
        return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]

    area = cross(b - a, c - a)
    flat = np.abs(area) < 1e-12
    second = cross(points - a, c - a) / np.where(flat, 1.0, area)
    third = cross(b - a, points - a) / np.where(flat, 1.0, area)
    return np.asarray(np.where(flat[:, None], -1.0, np.stack([1.0 - second - third, second, third], axis=1)))
