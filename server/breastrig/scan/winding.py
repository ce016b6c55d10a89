"""Orients all triangles outwards: some programs write them inside-out, or inconsistently.

Neighbours across an edge agree when they run along it in opposite directions. Triangles that agree form patches, of
which a scan has few; from the first patch of each piece on, every second one is turned. Then each piece as a whole is
turned so that it faces away from the middle of what lies behind it.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, any_in_row, stable_order
from breastrig.geometry.boundary import components
from breastrig.geometry.normals import face_crosses

ROUND = 0.2  # mean cosine between normals and the arms from the piece's middle: a plane has 0, a ball 1, a torso 0.5


def _neighbours(faces: Integers) -> tuple[Integers, Integers, Booleans]:
    """Pairs of triangles that share an edge with exactly one other, and whether they disagree along it."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    forward = start < end
    key = np.where(forward, start, end) * (int(faces.max()) + 1) + np.where(forward, end, start)
    order = stable_order(key)
    ordered = key[order]
    same = ordered[1:] == ordered[:-1]
    alone = same.copy()  # edges of exactly two triangles
    alone[:-1] &= ~same[1:]
    alone[1:] &= ~same[:-1]
    pairs = np.flatnonzero(alone)
    first, second = order[pairs], order[pairs + 1]
    first, second = np.minimum(first, second), np.maximum(first, second)
    return first // 3, second // 3, forward[first] == forward[second]


def consistent(faces: Integers) -> tuple[Integers, Integers]:
    """(F, 3) triangles that agree with their neighbours, and the (F,) piece that each belongs to."""
    a, b, differ = _neighbours(faces)
    patches, patch = components(len(faces), a[~differ], b[~differ])
    if not differ.any():
        return faces, patch
    first, second = patch[a[differ]], patch[b[differ]]
    _, piece = components(patches, first, second)
    turned = _at_odd_depth(np.unique(piece, return_index=True)[1], patches, first, second)[patch]
    return np.where(turned[:, None], faces[:, ::-1], faces), piece[patch]


def _at_odd_depth(roots: Integers, count: int, first: Integers, second: Integers) -> Booleans:
    """(N,) of `count` nodes, joined by E edges: those an odd number of edges from their root, by the shortest way."""
    start, end = np.concatenate([first, second]), np.concatenate([second, first])
    end = end[stable_order(start)]
    sizes = np.bincount(start, minlength=count)
    offsets = np.cumsum(sizes) - sizes
    odd, reached = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    front, is_odd = roots, False
    while len(front):
        odd[front], reached[front] = is_odd, True
        many = sizes[front]
        met = end[np.repeat(offsets[front] - (np.cumsum(many) - many), many) + np.arange(many.sum())]
        front, is_odd = np.unique(met[~reached[met]]), not is_odd
    return odd


def outwards(vertices: Array, faces: Integers, crosses: Array | None = None) -> tuple[Integers, int]:
    """(F, 3) triangles facing outwards, for (V, 3) vertices, and how many were turned.

    A flat piece (a table, a scrap) has no inside: it faces the side that the body was seen from, which is the piece
    with most area times curvature: a scrap may be rounder than one side of a body.
    `crosses` are the face_crosses of the triangles, where they are known already.
    """
    turned, piece = consistent(faces)
    normals = face_crosses(vertices, faces) if crosses is None else crosses
    flipped = np.zeros(len(faces), dtype=np.bool_)
    if turned is not faces:
        flipped = any_in_row(turned != faces)
        normals = np.where(flipped[:, None], -normals, normals)
    middle = vertices.take(faces[:, 0], axis=0)
    middle += vertices.take(faces[:, 1], axis=0)
    middle += vertices.take(faces[:, 2], axis=0)
    middle /= 3.0
    area = np.sqrt(np.einsum("fi,fi->f", normals, normals))

    def summed(values: Array) -> Array:
        return np.asarray(np.bincount(piece, weights=values))

    total = np.maximum(summed(area), 1e-30)
    centre = np.stack([summed(area * middle[:, axis]) for axis in range(3)], axis=1) / total[:, None]
    arm = middle
    arm -= centre.take(piece, axis=0)
    outward = summed(np.einsum("fi,fi->f", normals, arm))
    roundness = outward / np.maximum(summed(area * np.sqrt(np.einsum("fi,fi->f", arm, arm))), 1e-30)
    side = np.where(outward < 0.0, -1.0, 1.0)
    mean = np.stack([summed(normals[:, axis]) for axis in range(3)], axis=1) * side[:, None]
    body = int(np.argmax(total * np.abs(roundness)))  # one side of a supine body has 0.10 to 0.27, its table 0.02
    like_body = np.where(mean @ mean[body] < 0.0, -1.0, 1.0)
    sign = np.where(np.abs(roundness) > ROUND, side, side * like_body)
    flipped ^= (sign < 0.0)[piece]
    if not flipped.any():
        return faces, 0
    return np.where(flipped[:, None], faces[:, ::-1], faces), int(np.count_nonzero(flipped))
