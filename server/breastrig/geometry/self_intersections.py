"""Self-intersections of a triangle mesh: edges that cross a triangle with which they share no corner.

The skin of a fitted model can have them in the armpit and in the fold under a breast, and a tetrahedral mesher refuses
it.

Exact tests (Möller and Trumbore 1997) of each edge with the triangles nearest to it. On a mesh with edges much longer
than their neighbours' the nearest are not all; a fitted model has none.
"""

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.half_edges import neighbours

ROUNDS = 40  # an armpit needs four
STEP = 0.2  # of the way to the neighbours' mean; 0.5 moves an armpit's skin twice as far
CANDIDATES = 64  # triangles looked at around each edge: three rings of neighbours and the other sheet


def crossing_faces(vertices: Array, faces: Integers) -> Integers:
    """(K,) triangles that take part in a crossing, ascending."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(faces)), 3)
    edges, first = np.unique(edges, axis=0, return_index=True)
    owners = owners[first]
    corners = vertices[faces]
    start, along = vertices[edges[:, 0]], vertices[edges[:, 1]] - vertices[edges[:, 0]]
    count = min(CANDIDATES, len(faces))
    _, near = cKDTree(corners.mean(axis=1)).query(start + 0.5 * along, k=count)
    edge, face = np.repeat(np.arange(len(edges)), count), near.ravel()
    shared = (faces[face][:, :, None] == edges[edge][:, None, :]).any(axis=(1, 2))
    edge, face = edge[~shared], face[~shared]
    a, b, c = corners[face].transpose(1, 0, 2)
    d, u, v = along[edge], b - a, c - a
    p = np.cross(d, v)
    det = np.einsum("mi,mi->m", u, p)
    safe = np.where(np.abs(det) > 1e-18, det, 1.0)
    t = start[edge] - a
    q = np.cross(t, u)
    s = np.einsum("mi,mi->m", t, p) / safe
    r = np.einsum("mi,mi->m", d, q) / safe
    reach = np.einsum("mi,mi->m", v, q) / safe
    hit = (np.abs(det) > 1e-18) & (s >= 0) & (r >= 0) & (s + r <= 1) & (reach >= 0) & (reach <= 1)
    return np.unique(np.concatenate([face[hit], owners[edge[hit]]]))


def untangled(vertices: Array, faces: Integers, rounds: int = ROUNDS) -> Array:
    """(V, 3) m: the vertices of crossing triangles moved towards the mean of their neighbours, a little at a time,
    until nothing crosses or the rounds are over; their neighbours follow when the first half of the rounds did not do.
    All others stay where they are.
    """
    links = neighbours(faces, len(vertices))
    result = vertices.copy()
    for done in range(rounds):
        crossing = crossing_faces(result, faces)
        if not len(crossing):
            break
        near = np.zeros(len(vertices))
        near[faces[crossing].ravel()] = 1.0
        chosen = (near if 2 * done < rounds else links @ near + near) > 0.0
        result[chosen] += STEP * ((links @ result) - result)[chosen]
    return result
