"""Open borders of a triangle mesh: where a scan ends, where the model is cut; and its connected pieces.

An edge is on the border when exactly one triangle owns it.  Loops follow the direction of the triangles, so
that the surface lies on the left of a walker who sees it from outside.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from breastrig.core.arrays import Booleans, Integers, stable_order


def directed_edges(faces: Integers) -> Integers:
    """(3F, 2): the edges of (F, 3) triangles in their direction, triangle by triangle."""
    return np.asarray(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))


def boundary_edges(faces: Integers) -> Integers:
    """(E, 2) directed edges that only one of the (F, 3) triangles owns."""
    if len(faces) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    start, end = faces.astype(np.int64).ravel(), np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    key = np.minimum(start, end) * (int(faces.max()) + 1) + np.maximum(start, end)
    order = stable_order(key)
    ordered = key[order]
    alone = np.ones(len(key), dtype=np.bool_)
    changes = ordered[1:] != ordered[:-1]
    alone[1:] &= changes
    alone[:-1] &= changes
    own = np.sort(order[alone])
    return np.stack([start[own], end[own]], axis=1)


def boundary_vertices(faces: Integers, vertex_count: int) -> Booleans:
    """(V,) True at the ends of border edges."""
    mask = np.zeros(vertex_count, dtype=np.bool_)
    mask[boundary_edges(faces).ravel()] = True
    return mask


def boundary_loops(faces: Integers) -> list[Integers]:
    """The borders as closed loops of vertex indices, the longest first; no vertex is repeated within a loop.

    Where two loops touch in one vertex they are parted there.  An open chain (a mesh whose triangles disagree
    about their direction) raises ValueError.
    """
    edges = boundary_edges(faces)
    leaving: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        leaving.setdefault(start, []).append(end)
    loops: list[list[int]] = []
    while leaving:
        path = [next(iter(leaving))]
        place = {path[0]: 0}
        while path:
            here = path[-1]
            ends = leaving.get(here)
            if ends is None:
                raise ValueError("The border does not close: triangles disagree about their direction.")
            there = ends.pop()
            if not ends:
                del leaving[here]
            if there not in place:
                place[there] = len(path)
                path.append(there)
                continue
            first = place[there]  # the walk came back: cut this loop off, go on with the rest
            loops.append(path[first:])
            for vertex in path[first:]:
                del place[vertex]
            del path[first:]
            if path:
                place[there] = first
                path.append(there)
    loops.sort(key=len, reverse=True)
    return [np.array(loop, dtype=np.int64) for loop in loops]


def components(count: int, first: Integers, second: Integers) -> tuple[int, Integers]:
    """The number of components of a graph of `count` nodes with M edges (M,), (M,), and (N,) each node's component.

    They are numbered by their smallest nodes.
    """
    joined = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    number, component = connected_components(joined, directed=False)
    return int(number), component.astype(np.int64)


def triangle_components(faces: Integers, count: int) -> tuple[int, Integers]:
    """`components` of `count` vertices, joined by (F, 3) triangles."""
    first, second = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()  # the third edge joins nothing new
    return components(count, first, second)
