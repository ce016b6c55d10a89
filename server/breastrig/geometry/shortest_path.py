"""The shortest path between two vertices of a mesh, traced by the exact distances to one of them.

libigl measures exact distances but hands out no paths.  A shortest path is straight where the triangles that it
crosses are unfolded into a plane, and it bends at vertices only (Mitchell, Mount and Papadimitriou, SIAM J. Comput.
16, 1987).  So from each vertex of the path the triangles ahead are unfolded, window by window, until a vertex c is
seen from which what is left is exactly what remains: |c - u| + d(c) = d(u).

Windows that cannot hold the path are dropped: at x along an edge from a to b of length l the distance is at least
max(d(a) - x, d(b) - (l - x)), and the smallest sum of that and of the straight line to x lies where both are equal,
or at that end of the window which is nearer to it, as |p(x)| - x falls and |p(x)| + x rises along the edge.
"""

from collections import defaultdict
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from breastrig.core.arrays import Array, Integers

TOLERANCES = 1e-10 * 10.0 ** np.arange(6)  # m; sums of lengths are right to 1e-15, the others are for worse meshes

Flat = tuple[float, float]  # m, in the plane of the unfolded triangles; the vertex looked from is the origin


@dataclass(frozen=True, eq=False)
class _Window:
    """The part of an edge that is seen from the origin, between two directions."""

    first: int  # the edge's vertices; `first` lies clockwise of `second`
    second: int
    at_first: Flat
    at_second: Flat
    right: Flat  # directions between which the edge is seen, counter-clockwise
    left: Flat
    behind: int  # the triangle on the side of the origin
    before: "_Window | None"  # what it is seen through


class PathTracer:
    """Shortest paths to one vertex of a mesh of (V, 3) vertices (m) and (F, 3) triangles.

    `distances` (V,) m are the exact ones to that vertex along the mesh.
    """

    def __init__(self, vertices: Array, faces: Integers, distances: Array) -> None:
        self._vertices, self._distances = vertices, distances.tolist()
        self._faces: list[list[int]] = faces.tolist()
        corners = vertices[faces]
        self._lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).tolist()  # of edges k, k + 1
        self._around: dict[int, list[int]] = defaultdict(list)
        self._beside: dict[tuple[int, int], list[int]] = defaultdict(list)
        for number, face in enumerate(self._faces):
            for k in range(3):
                self._around[face[k]].append(number)
                a, b = face[k], face[(k + 1) % 3]
                self._beside[(a, b) if a < b else (b, a)].append(number)

    def path(self, start: int) -> Array:
        """(M, 3) m: the shortest path from vertex `start` to where the distance is zero."""
        points = [self._vertices[start]]
        while self._distances[start] > 0.0:
            crossings, start = self._straight_on(start)
            points += [*crossings, self._vertices[start]]
        return np.array(points)

    def _straight_on(self, start: int) -> tuple[list[Array], int]:
        """The next vertex of the path, and the (3,) points of the edges that are crossed on the way."""
        for tolerance in TOLERANCES:
            found = self._seen(start, float(tolerance))
            if found is not None:
                window, end, place = found
                return self._crossings(window, place), end
        raise ArithmeticError("The distances do not belong to this mesh.")

    def _seen(self, start: int, tolerance: float) -> tuple[_Window | None, int, Flat] | None:
        """A vertex of the shortest path that is seen from `start`: through which window, which one, and where."""
        d, limit = self._distances, self._distances[start] + tolerance
        waiting = _Waiting()
        for number in self._around[start]:
            face = self._faces[number]
            k = face.index(start)
            a, b, lengths = face[(k + 1) % 3], face[(k + 2) % 3], self._lengths[number]
            to_a, to_b = lengths[k], lengths[(k + 2) % 3]
            for end, length in ((a, to_a), (b, to_b)):
                if length + d[end] <= limit and d[end] < d[start]:
                    return None, end, (length, 0.0)
            at_a, at_b = (to_a, 0.0), _apex(to_a, to_b, lengths[(k + 1) % 3])
            self._add(waiting, _Window(a, b, at_a, at_b, at_a, at_b, number, None), limit)
        while (window := waiting.pop()) is not None:
            a, b = window.first, window.second
            for number in self._beside[(a, b) if a < b else (b, a)]:
                if number == window.behind:
                    continue
                end, place = self._unfolded(window, number)
                seen_right, seen_left = _turn(window.right, place) >= 0.0, _turn(place, window.left) >= 0.0
                if seen_right and seen_left and np.hypot(*place) + d[end] <= limit:
                    return window, end, place
                if seen_right:  # the edge on the right, up to the new vertex or the window's left end
                    left = place if seen_left else window.left
                    self._add(
                        waiting, _Window(a, end, window.at_first, place, window.right, left, number, window), limit
                    )
                if seen_left:
                    right = place if seen_right else window.right
                    self._add(
                        waiting, _Window(end, b, place, window.at_second, right, window.left, number, window), limit
                    )
        return None

    def _unfolded(self, window: _Window, number: int) -> tuple[int, Flat]:
        """The third vertex of a triangle beyond the window, and its place in the plane."""
        face, lengths = self._faces[number], self._lengths[number]
        k = next(k for k in range(3) if face[k] not in (window.first, window.second))
        after, before = face[(k + 1) % 3], lengths[(k + 2) % 3]
        from_first, from_second = (lengths[k], before) if after == window.first else (before, lengths[k])
        (ax, ay), (bx, by) = window.at_first, window.at_second
        length = float(np.hypot(bx - ax, by - ay))
        along, off = _apex(length, from_first, from_second)
        ux, uy = (bx - ax) / length, (by - ay) / length
        return face[k], (ax + along * ux + off * uy, ay + along * uy - off * ux)  # on the far side from the origin

    def _add(self, waiting: "_Waiting", window: _Window, limit: float) -> None:
        """Keeps the window when a path through it can be short enough."""
        d = self._distances
        low, high = _along(window, window.right), _along(window, window.left)
        (ax, ay), (bx, by) = window.at_first, window.at_second
        length = float(np.hypot(bx - ax, by - ay))
        if length == 0.0:
            return
        at = min(max(0.5 * (d[window.first] - d[window.second] + length) / length, low), high)
        straight = float(np.hypot(ax + at * (bx - ax), ay + at * (by - ay)))
        least = straight + max(d[window.first] - at * length, d[window.second] - (1.0 - at) * length)
        if least <= limit:
            waiting.add(least - straight, window)

    def _crossings(self, window: _Window | None, place: Flat) -> list[Array]:
        """(3,) m each: where the straight line from the origin to `place` crosses the windows on its way."""
        points = []
        while window is not None:
            share = _along(window, place)
            a, b = self._vertices[[window.first, window.second]]
            points.append(a + share * (b - a))
            window = window.before
        return points[::-1]


class _Waiting:
    """Windows still to look through, the one with the least left to go first."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, _Window]] = []
        self._added = 0

    def add(self, left_m: float, window: _Window) -> None:
        self._added += 1  # of two alike the newer, which windows cannot decide
        heappush(self._heap, (left_m, -self._added, window))

    def pop(self) -> _Window | None:
        return heappop(self._heap)[2] if self._heap else None


def _turn(u: Flat, v: Flat) -> float:
    """Above zero when v is counter-clockwise of u."""
    return u[0] * v[1] - u[1] * v[0]


def _apex(base: float, from_start: float, from_end: float) -> Flat:
    """(along, off) m of a triangle's tip over a base, by the lengths of its three edges."""
    along = 0.5 * (base * base + from_start * from_start - from_end * from_end) / max(base, 1e-300)
    return along, float(np.sqrt(max(from_start * from_start - along * along, 0.0)))


def _along(window: _Window, direction: Flat) -> float:
    """Share (0 to 1) of the window's edge at which a ray from the origin meets it."""
    a, b = _turn(window.at_first, direction), _turn(direction, window.at_second)
    return min(max(a / (a + b), 0.0), 1.0) if a + b > 0.0 else 0.5
