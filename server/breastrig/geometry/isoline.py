"""The line on a mesh along which a value at its vertices takes one level (marching triangles)."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers


@dataclass(frozen=True, eq=False)
class Isoline:
    """A closed line; it crosses M edges, one after the other."""

    edges: Integers  # (M, 2) vertices at the edge's ends
    faces: Integers  # (M,) a triangle that owns the edge


def longest_loop(faces: Integers, values: Array, level: float) -> Isoline | None:
    """The closed line with the most points; None when there is none or when a longer one ends at a border.

    Vertices at the level exactly count as above it.  Infinite values are above every level.
    """
    above = values >= level
    mixed = np.flatnonzero(above[faces].any(axis=1) & ~above[faces].all(axis=1))
    if len(mixed) == 0:
        return None
    ends = np.stack([faces[mixed], np.roll(faces[mixed], -1, axis=1)], axis=2)  # (M, 3, 2)
    crossing = above[ends[..., 0]] != above[ends[..., 1]]  # two of three
    pairs = np.sort(ends[crossing].reshape(-1, 2), axis=1)
    edges, which = np.unique(pairs, axis=0, return_inverse=True)
    segments = which.reshape(-1, 2)
    around: list[list[tuple[int, int]]] = [[] for _ in edges]
    for face, (one, other) in zip(mixed.tolist(), segments.tolist(), strict=True):
        around[one].append((other, face))
        around[other].append((one, face))
    best, best_open = ([], []), 0  # type: tuple[list[int], list[int]], int
    seen = np.zeros(len(edges), dtype=np.bool_)
    for first in sorted(range(len(edges)), key=lambda edge: len(around[edge])):  # open ends first
        if seen[first]:
            continue
        line, owners, here = [], [], first
        while not seen[here]:
            seen[here] = True
            line.append(here)
            owners.append(around[here][0][1])
            here = next((other for other, _ in around[here] if not seen[other]), here)
        if len(around[first]) == 1:
            best_open = max(best_open, len(line))
        elif len(line) > len(best[0]):
            best = (line, owners)
    if len(best[0]) < 3 or best_open > len(best[0]):
        return None
    return Isoline(edges[best[0]], np.array(best[1], dtype=np.int64))
