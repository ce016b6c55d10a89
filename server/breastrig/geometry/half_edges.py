"""The triangles of a mesh side by side: flattened, to walk straight across them; their neighbours; split flat.

Half-edge 3 f + k is the edge of triangle f opposite its corner k, entered from the other side: seen from there the
corner k + 1 is its left end and k + 2 its right one.  Triangles are counter-clockwise from outside.
"""

from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from breastrig.core.arrays import Array, Booleans, Integers, stable_order

SADDLE = 1e-9  # rad above a full turn from which a vertex casts a shadow: 0.05 nm at 5 cm


class HalfEdges:
    """The half-edges of (V, 3) m vertices and (F, 3) triangles; arrays are (3 F,) unless stated otherwise."""

    def __init__(self, vertices: Array, faces: Integers) -> None:
        self.vertices, self.faces = vertices, faces
        self.apex = faces.ravel()
        self.left = np.roll(faces, -1, axis=1).ravel()
        self.right = np.roll(faces, 1, axis=1).ravel()
        edge = vertices[self.right] - vertices[self.left]
        self.length = np.sqrt(np.einsum("hi,hi->h", edge, edge))
        square = np.maximum(self.length**2, 1e-300)
        tip = vertices[self.apex] - vertices[self.left]
        along = np.einsum("hi,hi->h", tip, edge) / square
        off = np.sqrt(np.maximum(np.einsum("hi,hi->h", tip, tip) / square - along**2, 0.0))
        # the corner beyond, unfolded into the plane: left + (right − left) · beyond
        self.beyond = along + 1j * off
        self.mate = self._mates()
        turned = np.arange(len(self.apex)).reshape(-1, 3)
        self.beyond_left = self.mate[np.roll(turned, 1, axis=1).ravel()]  # through the edge from the tip to the left
        self.beyond_right = self.mate[np.roll(turned, -1, axis=1).ravel()]

    def _mates(self) -> Integers:
        """The half-edge of the triangle on the near side that is the same edge; -1 at a border."""
        count = len(self.vertices)
        key, turned = self.left * count + self.right, self.right * count + self.left
        order = stable_order(key)
        at = np.searchsorted(key[order], turned).clip(0, max(len(key) - 1, 0))
        return np.where(key[order[at]] == turned, order[at], -1)

    @cached_property
    def spans(self) -> Array:
        """(F,) m: the longest edge of each triangle."""
        return np.asarray(np.maximum(np.maximum(self.length[0::3], self.length[1::3]), self.length[2::3]))

    @cached_property
    def middles(self) -> Array:
        """(F, 3) m"""
        a, b, c = self.faces.T
        return np.asarray((self.vertices[a] + self.vertices[b] + self.vertices[c]) / 3.0)

    @cached_property
    def angle(self) -> Array:
        """rad at the corner."""
        to_left = self.vertices[self.left] - self.vertices[self.apex]
        to_right = self.vertices[self.right] - self.vertices[self.apex]
        across = np.cross(to_left, to_right)
        sines = np.sqrt(np.einsum("hi,hi->h", across, across))
        return np.asarray(np.arctan2(sines, np.einsum("hi,hi->h", to_left, to_right)))

    @cached_property
    def _fans(self) -> tuple[Array, Booleans, Booleans]:
        """The angle (rad) at which each corner begins in its vertex's fan, (V,) closed fans, (V,) vertices with
        several."""
        count, corners = len(self.vertices), np.arange(len(self.apex))
        # counter-clockwise around a vertex comes the corner beyond the edge from the vertex to the right end
        after = self.mate[3 * (corners // 3) + (corners + 1) % 3]
        after = np.where(after >= 0, 3 * (after // 3) + (after + 1) % 3, -1)
        first = np.ones(len(corners), dtype=np.bool_)
        first[after[after >= 0]] = False
        starts = np.full(count, -1)
        starts[self.apex[::-1]] = corners[::-1]
        closed = np.ones(count, dtype=np.bool_)
        closed[self.apex[first]] = False
        starts[self.apex[first]] = corners[first]
        begins, here = np.zeros(len(corners)), starts[starts >= 0]
        seen = np.zeros(len(corners), dtype=np.bool_)
        passed = np.zeros(len(here))
        while len(here):
            begins[here], seen[here] = passed, True
            passed, here = passed + self.angle[here], after[here]
            on = (here >= 0) & ~seen[here]
            passed, here = passed[on], here[on]
        several = np.zeros(count, dtype=np.bool_)
        several[self.apex[~seen]] = True
        return begins, closed, several

    @property
    def begins(self) -> Array:
        """rad from the beginning of the vertex's fan to the corner's edge to the left."""
        return self._fans[0]

    @property
    def closed(self) -> Booleans:
        """(V,) triangles all around."""
        return self._fans[1]

    @property
    def several(self) -> Booleans:
        """(V,) parts of the mesh touch here in a point."""
        return self._fans[2]

    @cached_property
    def total(self) -> Array:
        """(V,) rad around each vertex."""
        return np.asarray(np.bincount(self.apex, self.angle, len(self.vertices)), dtype=np.float64)

    @cached_property
    def bends(self) -> Booleans:
        """(V,) at which a shortest path may bend."""
        return (self.total > 2.0 * np.pi + SADDLE) | ~self.closed | self.several

    @cached_property
    def around(self) -> tuple[Integers, Integers]:
        """(V + 1,) offsets into (3 F,) corners, vertex by vertex."""
        counts = np.bincount(self.apex, minlength=len(self.vertices))
        return np.concatenate([[0], np.cumsum(counts)]), stable_order(self.apex)


def neighbours(triangles: Integers, count: int) -> csr_array:
    """(N, N) rows that average over the neighbours of each vertex; a vertex without triangles has an empty one."""
    i, j = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    both = coo_array((np.ones(2 * len(i)), (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(count, count))
    links = csr_array(both)
    links.data[:] = 1.0
    return csr_array(diags_array(1.0 / np.maximum(links.sum(axis=1), 1.0)) @ links)


PIECES = ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])  # corners 0 to 2, the middles of the edges after them 3 to 5


def split_flat(vertices: Array, faces: Integers) -> tuple[Array, Integers, Integers]:
    """The mesh with each triangle split into four: vertices, faces, each new face's index of the old one."""
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
