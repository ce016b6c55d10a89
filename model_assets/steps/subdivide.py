"""Catmull-Clark subdivision of a quad mesh as one sparse matrix (Catmull and Clark 1978).

The source's quads are 15 to 30 mm wide; two rounds make a surface smooth enough to be sampled anywhere.
Because the rule is linear, the same matrix carries positions, displacements and skin weights.
"""

import numpy as np
from scipy import sparse

from steps.source import Integers


def subdivide(quads: Integers, count: int) -> tuple[sparse.csr_matrix, Integers]:
    """((W, V) matrix from old to new vertices, (4Q, 4) new quads) for a mesh of (Q, 4) quads and V = `count`."""
    edges = np.sort(np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    unique, inverse, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(4, -1).T  # (Q, 4): edge i joins corners i and i + 1
    faces, borders = len(quads), uses == 1
    quarter = np.full(4 * faces, 0.25)
    face_points = sparse.csr_matrix((quarter, (np.repeat(np.arange(faces), 4), quads.ravel())), (faces, count))
    ends = sparse.csr_matrix(
        (np.full(2 * len(unique), 0.5), (np.repeat(np.arange(len(unique)), 2), unique.ravel())), (len(unique), count)
    )
    around = sparse.csr_matrix(
        (np.full(4 * faces, 0.5), (inverse.ravel(), np.repeat(np.arange(faces), 4))), (len(unique), faces)
    )
    inner = sparse.diags((~borders).astype(float))
    edge_points = ends - 0.5 * inner @ ends + 0.5 * inner @ (around @ face_points)

    # vertex rule: (F + 2 R + (n - 3) P) / n inside, (1, 6, 1) / 8 along borders
    valence = np.bincount(quads.ravel(), minlength=count).astype(float)
    on_border = np.zeros(count, dtype=bool)
    on_border[unique[borders].ravel()] = True
    used = valence > 0
    safe = np.where(used, valence, 1.0)
    to_faces = sparse.csr_matrix((np.ones(4 * faces), (quads.ravel(), np.repeat(np.arange(faces), 4))), (count, faces))
    to_edges = sparse.csr_matrix(
        (np.ones(2 * len(unique)), (unique.ravel(), np.repeat(np.arange(len(unique)), 2))), (count, len(unique))
    )
    edge_valence = np.maximum(np.asarray(to_edges.sum(axis=1)).ravel(), 1.0)
    smooth = (
        sparse.diags(1.0 / safe**2) @ to_faces @ face_points
        + sparse.diags(2.0 / (safe * edge_valence)) @ to_edges @ ends
        + sparse.diags((safe - 3.0) / safe)
    )
    border_edges = to_edges @ sparse.diags(borders.astype(float)) @ ends
    border = 0.25 * border_edges + sparse.diags(np.full(count, 0.5))
    vertex_points = sparse.diags((used & ~on_border).astype(float)) @ smooth
    vertex_points = vertex_points + sparse.diags((used & on_border).astype(float)) @ border
    vertex_points = vertex_points + sparse.diags((~used).astype(float))

    matrix = sparse.vstack([vertex_points, edge_points, face_points]).tocsr()
    face_ids = count + len(unique) + np.arange(faces)
    edge_ids = count + inverse
    children = [np.stack([quads[:, i], edge_ids[:, i], face_ids, edge_ids[:, (i + 3) % 4]], axis=1) for i in range(4)]
    return matrix, np.concatenate(children)
