"""Distances by libigl's exact window propagation, one vertex at a time: the reference of distance_field.py.

Mitchell, Mount and Papadimitriou's algorithm in another implementation, which knows nothing of ours.
"""

import igl
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from breastrig.geometry.fields.level_sets import longest_loop
from breastrig.geometry.half_edges import split_flat

SNAP = 1e-4  # barycentric share under which a point counts as on the edge or corner: 1 µm on an edge of 10 mm


def with_vertex(
    vertices: np.ndarray, faces: np.ndarray, face: int, barycentric: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """The mesh with a vertex at a surface point: vertices, faces, each face's index before, the vertex' index.

    Inside a triangle it makes three of one, on an edge two of each neighbour; at a corner nothing changes.
    """
    parents = np.arange(len(faces))
    share = np.where(np.asarray(barycentric) < SNAP, 0.0, barycentric)
    share = share / share.sum()
    corners = faces[face]
    if np.count_nonzero(share) == 1:
        return vertices, faces, parents, int(corners[share.argmax()])
    new = len(vertices)
    vertices = np.concatenate([vertices, share[None] @ vertices[corners]])
    if np.count_nonzero(share) == 3:
        split = np.array([face])
        pieces = np.array([[corners[k], corners[(k + 1) % 3], new] for k in range(3)])
        owners = np.full(3, face)
    else:
        ends = corners[share > 0.0]
        split = np.flatnonzero(np.isin(faces, ends).sum(axis=1) == 2)
        first, second = (np.where(faces[split] == end, new, faces[split]) for end in ends)
        pieces, owners = np.concatenate([first, second]), np.concatenate([split, split])
    faces = np.concatenate([np.delete(faces, split, axis=0), pieces])
    return vertices, faces, np.concatenate([np.delete(parents, split), owners]), new


def exact_distances(vertices: np.ndarray, faces: np.ndarray, face: int, barycentric: np.ndarray) -> np.ndarray:
    """(V,) m from a surface point to each vertex; inf where unconnected."""
    count = len(vertices)
    vertices, faces, _, source = with_vertex(vertices, faces, face, barycentric)
    return _from_vertex(vertices, faces, source)[:count]


def exact_circle(
    vertices: np.ndarray, faces: np.ndarray, face: int, barycentric: np.ndarray, radius: float, fineness: int = 8
) -> np.ndarray:
    """(M, 3) m: the closed line at a distance, on a neighbourhood split until its edges are `fineness` in a radius."""
    source = barycentric @ vertices[faces[face]]
    near = np.flatnonzero(np.linalg.norm(vertices[faces] - source, axis=2).min(axis=1) <= 1.3 * radius)
    near = np.union1d(near, [face])
    vertices, patch, _, centre = with_vertex(vertices, faces[near], int(np.searchsorted(near, face)), barycentric)
    while np.linalg.norm(vertices[patch] - np.roll(vertices[patch], 1, axis=1), axis=2).max() > radius / fineness:
        vertices, patch, _ = split_flat(vertices, patch)
        patch = patch[np.linalg.norm(vertices[patch] - source, axis=2).min(axis=1) <= 1.1 * radius]
    measured = _from_vertex(vertices, patch, centre)
    rim = longest_loop(patch, measured, radius)
    assert rim is not None
    a, b = rim.edges.T
    share = ((radius - measured[a]) / (measured[b] - measured[a]))[:, None]
    return (1.0 - share) * vertices[a] + share * vertices[b]


def _from_vertex(vertices: np.ndarray, faces: np.ndarray, source: int) -> np.ndarray:
    """Only connected triangles are handed over: the library answers garbage for others."""
    result = np.full(len(vertices), np.inf)
    links = (np.ones(faces.size), (faces.ravel(), np.roll(faces, 1, axis=1).ravel()))
    _, piece = connected_components(csr_array(links, shape=(len(vertices), len(vertices))), directed=False)
    used, compact = np.unique(faces[piece[faces[:, 0]] == piece[source]], return_inverse=True)
    none, everywhere = np.zeros(0, dtype=np.int64), np.arange(len(used))
    start = np.searchsorted(used, [source])
    result[used] = igl.exact_geodesic(vertices[used], compact.reshape(-1, 3), start, none, everywhere, none)
    return result
