"""Level sets of a function that is given at the vertices of a triangle mesh.

The function is linear on each triangle, so cuts are exact for it.  `part_above` is the part of the mesh where it is
above a level: moving the level moves the border of the part.  `crossings` are the points where it passes the level,
and `longest_loop` is the closed line that they form (marching triangles).
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers


@dataclass(frozen=True, eq=False)
class Isoline:
    """A closed line; it crosses M edges, one after the other."""

    edges: Integers  # (M, 2) vertices at the edge's ends
    faces: Integers  # (M,) a triangle that owns the edge


def crossings(vertices: Array, faces: Integers, values: Array, level: float) -> Array:
    """(M, 3) points of the edges where the (V,) values pass the level; each edge once, ordered by its ends."""
    above = values > level
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[above[edges[:, 0]] != above[edges[:, 1]]]  # few, and sorting all would take the most time here
    return _cut(vertices, values, level, np.unique(np.sort(edges, axis=1), axis=0))


def part_above(vertices: Array, faces: Integers, values: Array, level: float) -> tuple[Array, Integers]:
    """((W, 3) vertices, (G, 3) triangles in their old direction) of the part where the (V,) values are above it."""
    above = values > level
    count = above[faces].sum(axis=1)
    triangles = [faces[count == 3]]
    mixed = faces[(count == 1) | (count == 2)]
    odd = np.argmax(above[mixed] == (above[mixed].sum(axis=1) == 1)[:, None], axis=1)  # the corner alone on its side
    turned = np.stack([mixed[np.arange(len(mixed)), (odd + k) % 3] for k in range(3)], axis=1)
    edges = np.concatenate([turned[:, [0, 1]], turned[:, [0, 2]]])
    unique, index = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    first, second = (len(vertices) + index.ravel()).reshape(2, -1)
    alone, b, c = turned.T
    tip = above[alone]
    triangles.append(np.stack([alone, first, second], axis=1)[tip])
    triangles.append(np.stack([first, b, c], axis=1)[~tip])
    triangles.append(np.stack([first, c, second], axis=1)[~tip])
    points = np.concatenate([vertices, _cut(vertices, values, level, unique)])
    used, renumbered = np.unique(np.concatenate(triangles), return_inverse=True)
    return points[used], np.asarray(renumbered.reshape(-1, 3), dtype=np.int64)


def longest_loop(faces: Integers, values: Array, level: float) -> Isoline | None:
    """The closed line with the most points; None when there is none or when a longer one ends at a border.

    Vertices at the level exactly count as above it.  Infinite values are above every level.
    """
    above = values >= level
    a, b, c = above[faces.T]
    mixed = np.flatnonzero((a != b) | (b != c))
    if len(mixed) == 0:
        return None
    corners = faces[mixed]
    starts, stops = corners.ravel(), corners[:, [1, 2, 0]].ravel()
    crossing = np.flatnonzero(above[starts] != above[stops])  # two edges of each triangle
    starts, stops = starts[crossing], stops[crossing]
    keys = np.minimum(starts, stops) * len(values) + np.maximum(starts, stops)  # rows would sort slowly
    unique, which = np.unique(keys, return_inverse=True)
    edges = np.stack(np.divmod(unique, len(values)), axis=1)
    # of each edge its neighbours on the line, in the order of their triangles: one at an open end, else two
    order = np.argsort(which, kind="stable")
    others, owners = which[order ^ 1], mixed[order // 2]
    firsts = np.searchsorted(which[order], np.arange(len(edges) + 1))
    ways = np.diff(firsts)
    one, other = others[firsts[:-1]].tolist(), others[firsts[1:] - 1].tolist()
    seen = [False] * len(edges)
    best: list[int] = []
    best_open = 0
    for first in np.argsort(ways, kind="stable").tolist():  # open ends first
        line, here = [], first
        while not seen[here]:
            seen[here] = True
            line.append(here)
            here = other[here] if seen[one[here]] else one[here]
        if ways[first] == 1:
            best_open = max(best_open, len(line))
        elif len(line) > len(best):
            best = line
    if len(best) < 3 or best_open > len(best):
        return None
    return Isoline(edges[best], owners[firsts[best]])


def _cut(vertices: Array, values: Array, level: float, edges: Integers) -> Array:
    a, b = edges.T
    share = ((level - values[a]) / np.where(edges[:, 0] == edges[:, 1], 1.0, values[b] - values[a]))[:, None]
    return np.asarray((1.0 - share) * vertices[a] + share * vertices[b])
