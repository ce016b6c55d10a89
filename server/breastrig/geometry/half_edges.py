"""The triangles of a mesh side by side, flattened: what is needed to walk straight across it.

Half-edge 3 f + k is the edge of triangle f opposite its corner k, entered from the other side: seen from there the
corner k + 1 is its left end and k + 2 its right one.  Triangles are counter-clockwise from outside.
"""

from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.stable_order import stable_order

SADDLE = 1e-9  # rad above a full turn from which a vertex casts a shadow: 0.05 nm at 5 cm


class HalfEdges:
    """Of (V, 3) m vertices and (F, 3) triangles; all arrays are (3 F,) unless they say otherwise."""

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
        """Where each corner begins in its vertex's fan (rad), and which vertices (V,) have a closed one, or several."""
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
