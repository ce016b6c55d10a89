"""Vertices that depend on the same bones and shapes, in groups that suit BLAS.

A vertex has at most four bones, and most shapes move a part of the body only: on the torso a row of the Jacobian is
zero in two of three columns.  The groups are made by cutting all vertices in two by the bone or shape whose absence
saves most work, again and again, as long as it saves more than one more group costs.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS

GROUP_COST = 2e6  # multiplications; what a group takes beside its products, 0.05 ms
ENTRY_COST = 30.0  # multiplications; what it takes to write one entry


@dataclass(frozen=True, eq=False)
class VertexGroup:
    """The bones and shapes of one group's vertices; C = 9 K + L + 1 columns, the residual is the last."""

    bones: Integers  # (K,)
    shapes: Integers  # (L,)
    entries: Integers  # (C²,) of the table ((P + 1)²,) of products


@dataclass(frozen=True, eq=False)
class VertexGroups:
    """All groups of a rig, and the data of its V vertices, group after group, without most of the zeros."""

    groups: tuple[VertexGroup, ...]
    of_vertex: Integers  # (V,) index of each vertex's group
    places: Integers  # (V,) index of each vertex in the arrays that follow
    weights: Array  # (max K, V) skin weights of the group's bones
    shapes: Array  # (3V, max L) m, the group's blendshapes, three rows a vertex


@lru_cache(maxsize=16)
def vertex_groups(rig: Rig) -> VertexGroups:
    """The vertex groups of a rig; takes 5 ms once."""
    bones = len(rig.bones)
    used: Booleans = np.concatenate([rig.skin_weights != 0.0, rig.shapes_by_vertex.any(axis=1)], axis=1)
    parts = _cut(used, np.concatenate([np.full(bones, float(BONE_DOFS)), np.ones(len(rig.shapes))]))
    groups = tuple(_group(np.asarray(used[vertices].any(axis=0)), bones) for vertices in parts)
    order = np.concatenate(parts)
    of_vertex, places = np.zeros((2, len(order)), dtype=np.int64)
    of_vertex[order] = np.repeat(np.arange(len(parts)), [len(vertices) for vertices in parts])
    places[order] = np.arange(len(order))
    weights = np.zeros((max(len(group.bones) for group in groups), len(order)))
    shapes = np.zeros((len(order), 3, max(len(group.shapes) for group in groups)))
    for vertices, group in zip(parts, groups, strict=True):
        weights[: len(group.bones), places[vertices]] = rig.weights_by_bone[group.bones][:, vertices]
        shapes[places[vertices], :, : len(group.shapes)] = rig.shapes_by_vertex[vertices][:, :, group.shapes]
    return VertexGroups(groups, of_vertex, places, weights, shapes.reshape(3 * len(order), -1))


def _cut(used: Booleans, widths: Array) -> list[Integers]:
    """The vertices of each group, ascending; used: (V, C) which bones and shapes, widths: (C,) of their columns."""
    counted, open_parts, parts = used.astype(np.float32), [np.arange(len(used))], []
    while open_parts:
        vertices = open_parts.pop()
        column = _best_cut(counted[vertices], widths)
        if column is None:
            parts.append(vertices)
        else:
            inside = used[vertices, column]
            open_parts += [vertices[~inside], vertices[inside]]
    return parts


def _group(used: Booleans, bones: int) -> VertexGroup:
    """used: (B + S,)"""
    columns = np.flatnonzero(np.concatenate([np.repeat(used[:bones], BONE_DOFS), used[bones:], [True]]))
    size = BONE_DOFS * bones + len(used) - bones + 1
    entries = (size * columns[:, None] + columns).ravel()
    return VertexGroup(np.flatnonzero(used[:bones]), np.flatnonzero(used[bones:]), entries)


def _best_cut(used: NDArray[np.float32], widths: Array) -> int | None:
    """The column whose use best divides (N, C) vertices, 0 or 1, in two; None where no division saves time."""
    both = (used.T @ used).astype(np.float64)
    total, count = np.diag(both), float(len(used))
    parted = _cost(total, (both > 0.0) @ widths) + _cost(count - total, (total - both > 0.0) @ widths)
    parted[(total == 0.0) | (total == count)] = np.inf
    best = int(parted.argmin())
    return best if parted[best] < _cost(np.array([count]), np.array([widths @ (total > 0.0)]))[0] else None


def _cost(rows: Array, columns: Array) -> Array:
    """(C,) of groups with so many rows and columns."""
    return np.asarray(rows * (columns * columns + ENTRY_COST * columns) + GROUP_COST)
