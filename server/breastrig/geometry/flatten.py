"""A piece of a surface laid flat: slit until it is a disc, then as rigid as possible in the plane.

Least squares conformal maps (Lévy et al. 2002) begin, local and global steps (Liu et al. 2008, ARAP) go on; both are
libigl's.  What lies in the plane is seen from outside.
"""

from dataclasses import dataclass

import igl
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadDrawing
from breastrig.geometry.boundary import boundary_edges, boundary_loops
from breastrig.geometry.closest_point import closest_barycentric

ROUNDS = 60  # of local and global steps; 300 change the lines of a breast by a tenth of a millimetre
INSIDE = 0.02  # barycentric share from which on a triangle's middle is inside another: they overlap


@dataclass(frozen=True, eq=False)
class Flattened:
    """A disc of W vertices; those of slits are there once for each side."""

    vertices: Array  # (W, 3) m
    faces: Integers  # (F, 3) in the given order
    flat: Array  # (W, 2) m
    slits: tuple[Integers, ...]  # for each slit its middle's vertices, one on each side

    @property
    def lifted(self) -> Array:
        """(W, 3) m: the flat places with a third coordinate of zero."""
        return np.column_stack([self.flat, np.zeros(len(self.flat))])


def flattened(vertices: Array, faces: Integers) -> Flattened:
    """(V, 3) m vertices and (F, 3) triangles, connected and with a border; BadDrawing where they overlap when flat."""
    cut, triangles, slits = slit(vertices, faces)
    rim = boundary_loops(triangles)[0]
    ends = np.array([rim[0], rim[len(rim) // 2]])
    apart = float(np.linalg.norm(cut[ends[1]] - cut[ends[0]]))
    try:
        conformal, _ = igl.lscm(cut, triangles, ends, np.array([[0.0, 0.0], [apart, 0.0]]))
        conformal *= np.sqrt(np.abs(_areas(cut, triangles)).sum() / np.abs(_areas(conformal, triangles)).sum())
        data = igl.ARAPData()
        data.max_iter = ROUNDS
        igl.arap_precomputation(cut, triangles, 2, np.array([0], dtype=np.int32), data)
        flat = np.ascontiguousarray(igl.arap_solve(conformal[:1].copy(), data, conformal))
    except RuntimeError as error:  # triangles without area, or no single piece
        raise BadDrawing("The skin below these lines cannot be laid flat.") from error
    if overlapping(flat, triangles).any():
        raise BadDrawing("These lines overlap each other when they are laid flat.")
    return Flattened(cut, triangles, flat, slits)


def slit(vertices: Array, faces: Integers) -> tuple[Array, Integers, tuple[Integers, ...]]:
    """The surface cut open along shortest paths between its borders until it has one; see `Flattened`."""
    a, b = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0).T
    spans = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    graph = csr_array((spans, (a, b)), shape=(len(vertices), len(vertices)))
    borders = boundary_loops(faces)
    paths: list[Integers] = []
    while len(borders) > 1:
        inner = borders.pop()  # the shortest
        away, before, _ = dijkstra(graph, directed=False, indices=inner, min_only=True, return_predecessors=True)
        nearest = int(np.argmin([away[each].min() for each in borders]))
        path = [int(borders[nearest][away[borders[nearest]].argmin()])]
        while before[path[-1]] >= 0:
            path.append(int(before[path[-1]]))
        paths.append(np.array(path))
        borders[nearest] = np.concatenate([borders[nearest], inner, paths[-1]])
    keys = [np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1) for path in paths]
    cuts = {tuple(edge) for key in keys for edge in key.tolist()}
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 3, 2), axis=2)
    is_cut = np.array([[tuple(edge) in cuts for edge in triangle] for triangle in sides.tolist()])
    opened, triangles, origin = igl.cut_mesh(vertices, faces, is_cut)
    slits = tuple(np.flatnonzero(np.asarray(origin).ravel() == path[len(path) // 2]) for path in paths)
    return np.ascontiguousarray(opened), np.asarray(triangles, dtype=np.int64), slits


def unpinched(faces: Integers, chosen: Booleans) -> Booleans:
    """(F,) the chosen triangles and, where they touch in a corner alone, those around that corner."""
    while True:
        ends, counts = np.unique(boundary_edges(faces[chosen]), return_counts=True)
        grown = chosen | np.isin(faces, ends[counts > 2]).any(axis=1)
        if (grown == chosen).all():
            return chosen
        chosen = grown


def overlapping(flat: Array, faces: Integers) -> Booleans:
    """(F,) triangles that are turned over, or whose middle is inside another one, for (V, 2) m places."""
    lifted = np.column_stack([flat, np.zeros(len(flat))])
    middles = lifted[faces].mean(axis=1)
    reach = np.linalg.norm(lifted[faces] - middles[:, None], axis=2).max(axis=1)
    pairs = cKDTree(middles).query_pairs(reach.max(), output_type="ndarray")
    first, second = np.concatenate([pairs, pairs[:, ::-1]]).T
    near = np.linalg.norm(middles[first] - middles[second], axis=1) < reach[second]
    first, second = first[near], second[near]
    shares = closest_barycentric(middles[first], lifted[faces[second]])
    found = _areas(flat, faces) <= 0.0
    found[first[shares.min(axis=1) > INSIDE]] = True
    return np.asarray(found)


def _areas(places: Array, faces: Integers) -> Array:
    """(F,) m²; in the plane below zero for triangles that are turned over."""
    a, b, c = places[faces].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a) if places.shape[1] == 3 else _cross(b - a, c - a)
    return np.asarray(0.5 * (np.linalg.norm(cross, axis=1) if cross.ndim == 2 else cross))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
