"""A triangle mesh whose vertices are fixed mixtures of the source's vertices.

Cutting, sampling and mirroring only ever mix vertices, so one sparse matrix `mix` remembers where each vertex
came from and carries every displacement and skin weight of the source to the finished model.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from steps.source import Array, Booleans, Integers

SNAP = 1e-9  # m; nearer to the cut than this counts as on it


@dataclass(frozen=True, eq=False)
class Surface:
    """V vertices, F triangles, made of S source vertices."""

    vertices: Array  # (V, 3) m
    triangles: Integers  # (F, 3) counter-clockwise seen from outside
    mix: sparse.csr_matrix  # (V, S) rows sum to 1

    def carry(self, field: Array) -> Array:
        """A (S, ...) field of the source on this surface."""
        return np.asarray(self.mix @ field)


def compacted(surface: Surface, triangles: Integers) -> tuple[Surface, Integers]:
    """The surface with these triangles only and no unused vertices, and the (V',) kept vertices."""
    used, inverse = np.unique(triangles, return_inverse=True)
    return Surface(surface.vertices[used], inverse.reshape(-1, 3), surface.mix[used]), used


def component_of(surface: Surface, vertex: int) -> Integers:
    """(F', 3) the triangles of the connected component that contains `vertex`."""
    count = len(surface.vertices)
    t = surface.triangles
    graph = sparse.csr_matrix((np.ones(3 * len(t)), (t.ravel(), np.roll(t, 1, axis=1).ravel())), (count, count))
    _, label = sparse.csgraph.connected_components(graph, directed=False)
    return np.asarray(t[label[t[:, 0]] == label[vertex]])


def clipped(
    surface: Surface, labels: dict[str, Booleans], name: str, field: Array
) -> tuple[Surface, dict[str, Booleans]]:
    """The part where the (V,) field is >= 0, with new vertices exactly where it crosses zero.

    `labels` tells which vertices (V,) lie on earlier cuts; the answer adds the cut `name`.
    """
    value = np.where(np.abs(field) < SNAP, 0.0, field)
    t = surface.triangles
    count = len(surface.vertices)
    new: dict[tuple[int, int], int] = {}

    def crossing(a: int, b: int) -> int:
        return new.setdefault((min(a, b), max(a, b)), count + len(new))

    signs = np.sign(value[t])
    kept = [t[(signs >= 0).all(axis=1) & (signs > 0).any(axis=1)]]
    for f in np.flatnonzero((signs > 0).any(axis=1) & (signs < 0).any(axis=1)):
        polygon: list[int] = []
        corners = [int(c) for c in t[f]]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            if value[a] >= 0:
                polygon.append(a)
            if value[a] * value[b] < 0:
                polygon.append(crossing(a, b))
        kept.append(np.array([(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)]))
    pairs = np.array(list(new), dtype=np.int64).reshape(-1, 2)
    i, j = pairs[:, 0], pairs[:, 1]
    share = value[i] / (value[i] - value[j])
    rows = np.tile(np.arange(len(pairs)), 2)
    extra = sparse.csr_matrix((np.concatenate([1 - share, share]), (rows, pairs.T.ravel())), (len(pairs), count))
    grown = Surface(
        np.concatenate([surface.vertices, extra @ surface.vertices]),
        np.concatenate(kept),
        sparse.vstack([surface.mix, extra @ surface.mix]).tocsr(),
    )
    result, used = compacted(grown, grown.triangles)
    found = {key: np.concatenate([on, on[i] & on[j]])[used] for key, on in labels.items()}
    found[name] = np.concatenate([value == 0.0, np.ones(len(pairs), dtype=bool)])[used]
    return result, found
