"""Triangles split where they lie: the surface stays the same, its points get more names."""

import numpy as np

from breastrig.core.arrays import Array, Integers

PIECES = ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])  # corners 0 to 2, the middles of the edges after them 3 to 5
SNAP = 1e-4  # barycentric share under which a point counts as on the edge or corner: 1 µm on an edge of 10 mm


def with_vertex(
    vertices: Array, faces: Integers, face: int, barycentric: Array
) -> tuple[Array, Integers, Integers, int]:
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


def split_flat(vertices: Array, faces: Integers) -> tuple[Array, Integers, Integers]:
    """Each triangle into four of half its size: vertices, faces, the index of each face's triangle before."""
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    pairs, which = np.unique(np.minimum(a, b) * len(vertices) + np.maximum(a, b), return_inverse=True)
    middle = len(vertices) + which.reshape(-1, 3)
    both = np.concatenate([faces, middle], axis=1)
    pieces = np.concatenate([both[:, corners] for corners in PIECES])
    ends = np.stack(np.divmod(pairs, len(vertices)))
    return np.concatenate([vertices, vertices[ends].mean(axis=0)]), pieces, np.tile(np.arange(len(faces)), 4)


def split_places(places: Array) -> Array:
    """(4 F, 3, D) at the corners of the triangles that split_flat makes, for (F, 3, D) at those before."""
    both = np.concatenate([places, 0.5 * (places + np.roll(places, -1, axis=1))], axis=1)
    return np.concatenate([both[:, corners] for corners in PIECES])
