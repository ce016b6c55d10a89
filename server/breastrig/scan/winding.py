"""Triangles that all face outwards: some programs write them inside-out, or every which way.

Neighbours across an edge agree when they run along it in opposite directions.  A breadth-first tree over the
triangles carries "same as my parent or not" from each piece's root (by pointer doubling: log(depth) rounds of
array work instead of a loop over triangles); then each piece as a whole is turned so that it faces away from
the middle of what lies behind it.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.components import components
from breastrig.geometry.normals import face_crosses

ROUND = 0.2  # mean cosine between normals and the arms from the piece's middle: a plane has 0, a ball 1, a torso 0.5


def _neighbours(faces: Integers) -> tuple[Integers, Integers, Booleans]:
    """Pairs of triangles that share an edge with exactly one other, and whether they disagree along it."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    forward = start < end
    size = int(faces.max()) + 1
    key = np.minimum(start, end) * size + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    same = ordered[1:] == ordered[:-1]
    alone = same & ~np.append(same[1:], False) & ~np.insert(same[:-1], 0, False)  # edges of exactly two triangles
    first, second = order[:-1][alone], order[1:][alone]
    return first // 3, second // 3, forward[first] == forward[second]


def consistent(faces: Integers) -> tuple[Integers, Integers]:
    """(F, 3) triangles that agree with their neighbours, and the (F,) piece that each belongs to."""
    a, b, differ = _neighbours(faces)
    count = len(faces)
    pieces, piece = components(count, a, b)
    if not differ.any():
        return faces, piece
    import scipy.sparse as sp  # with its graphs 0.2 s to load, for the rare scan whose triangles disagree
    from scipy.sparse.csgraph import breadth_first_order

    graph = sp.csr_array((np.where(differ, 2.0, 1.0), (a, b)), shape=(count, count))
    graph = (graph + graph.T).tocsr()
    # one walk for all pieces: from a node of its own that leads to the first triangle of each
    roots = np.unique(piece, return_index=True)[1]
    start = sp.csr_array((np.ones(pieces), roots, [0, pieces]), shape=(1, count))
    walk = sp.block_array([[graph, None], [start, sp.csr_array((1, 1))]], format="csr")
    before = breadth_first_order(walk, count, directed=True)[1][:count].astype(np.int64)
    parent = np.where(before == count, np.arange(count), before)
    flipped = np.asarray(graph[np.arange(count), parent]).ravel() == 2.0
    while (parent != parent[parent]).any():
        flipped = flipped ^ flipped[parent]
        parent = parent[parent]
    return np.where(flipped[:, None], faces[:, ::-1], faces), piece


def outwards(vertices: Array, faces: Integers) -> tuple[Integers, int]:
    """(F, 3) triangles facing outwards, for (V, 3) vertices, and how many were turned.

    A flat piece (a table, a scrap) has no inside: it faces the side that the largest curved piece was seen from.
    """
    turned, piece = consistent(faces)
    normals = face_crosses(vertices, turned)
    middle = (vertices[turned[:, 0]] + vertices[turned[:, 1]] + vertices[turned[:, 2]]) / 3.0
    area = np.linalg.norm(normals, axis=1)

    def summed(values: Array) -> Array:
        return np.asarray(np.bincount(piece, weights=values))

    total = np.maximum(summed(area), 1e-30)
    centre = np.stack([summed(area * middle[:, axis]) for axis in range(3)], axis=1) / total[:, None]
    arm = middle - centre[piece]
    outward = summed(np.einsum("fi,fi->f", normals, arm))
    roundness = outward / np.maximum(summed(area * np.linalg.norm(arm, axis=1)), 1e-30)
    side = np.where(outward < 0.0, -1.0, 1.0)
    mean = np.stack([summed(normals[:, axis]) for axis in range(3)], axis=1) * side[:, None]
    body = int(np.argmax(total * (np.abs(roundness) > ROUND)))
    like_body = np.where(mean @ mean[body] < 0.0, -1.0, 1.0)
    sign = np.where(np.abs(roundness) > ROUND, side, side * like_body)
    turned = np.where((sign < 0.0)[piece][:, None], turned[:, ::-1], turned)
    return turned, int((turned != faces).any(axis=1).sum())
