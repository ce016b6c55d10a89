"""Exact distances and shortest paths along a mesh from some of its points.

A shortest path is straight where the triangles that it crosses are unfolded into a plane, and it bends at vertices
with more than a full turn around them and at borders only (Mitchell, Mount and Papadimitriou, SIAM J. Comput. 16,
1987).  So windows, parts of edges with the directions under which they are seen, go out from the source triangle by
triangle; where one passes a vertex it is cut in two, and where a path may bend the vertex sends out windows of its own
into what its shadow hides.  A window is dropped as soon as the way along an edge from a vertex is shorter for all that
it can still show (Xin and Wang, ACM Trans. Graph. 28 (4), 2009).

All windows of all sources that have crossed as many triangles go on at once, as arrays: several sources cost hardly
more than one.  libigl's exact_geodesic answers for vertices only: a circle then needs a mesh of many more, and takes
twenty times longer.  Points of the plane are complex numbers.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans, Complexes, Integers
from breastrig.geometry.half_edges import SADDLE, HalfEdges
from breastrig.geometry.surface_points import SurfacePoints

AT_CORNER = 1e-9  # barycentric share that may be missing at a corner
SHORTER = 1e-13  # m by which a way must be shorter to count: rounding of sums of lengths
ASIDE = 1e-12  # of a length, by which a point may miss a window
NONE = -1  # no window, no vertex


@dataclass(frozen=True, eq=False)
class _Windows:
    """N parts of edges, unfolded around the centre that sees them."""

    names: Integers  # (4, N) half-edge that is entered (half_edges.py), centre, window before, number of the source
    plane: Complexes  # (4, N) its left and right end (m), and the directions to the left and right between which it is

    def chosen(self, which: Booleans) -> "_Windows":
        rows = which.nonzero()[0]
        return _Windows(self.names.take(rows, axis=1), self.plane.take(rows, axis=1))


def _joined(parts: list[_Windows]) -> _Windows:
    if len(parts) == 1:
        return parts[0]
    return _Windows(
        np.concatenate([part.names for part in parts], axis=1), np.concatenate([part.plane for part in parts], axis=1)
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """The paths to N places: their window and centre, (2, N), and coordinates in the unfolded plane, (N,)."""

    names: Integers
    place: Complexes

    @staticmethod
    def directly(count: int) -> "_Seen":
        return _Seen(np.tile([[NONE], [0]], count), np.zeros(count, dtype=np.complex128))

    def put(self, where: Integers, other: "_Seen", which: Integers) -> None:
        self.names[:, where], self.place[where] = other.names[:, which], other.place[which]

    def chosen(self, which: Integers) -> "_Seen":
        return _Seen(self.names[:, which], self.place[which])


class DistanceFields:
    """Distances from S surface points up to (S,) `reach` (m), each point on its own.

    With `goals`, (S, 3) places, only the part that a path to the goal not longer than the reach can touch.
    """

    def __init__(self, mesh: HalfEdges, sources: SurfacePoints, reach: Array, goals: Array | None = None) -> None:
        self._mesh, self._sources, self.reach, self._goals = mesh, sources, reach, goals
        self._count = len(mesh.vertices)
        size = len(sources) * self._count
        self._places = sources.positions(mesh.vertices, mesh.faces)
        self._distances = np.full(size, np.inf)  # of the vertices, source by source
        self._bends = np.tile(mesh.bends, len(sources))
        self._incoming = np.zeros(size)  # rad in the vertex's fan, to where the shortest way comes from
        self._seen = _Seen.directly(size)
        self._sent = np.repeat(reach, self._count)  # the distance under which a vertex sends out windows, again
        self._centres = np.full(len(sources), NONE)  # the vertex of each; first come the sources
        self._offsets = np.zeros(len(sources))  # m, of each from the source
        self._centres_seen = _Seen.directly(len(sources))
        self._windows = self._spread([self._first(number) for number in range(len(sources))])
        owners = self._windows.names[3] * len(mesh.faces) + self._windows.names[0] // 3
        self._by_face = np.argsort(owners, kind="stable")
        self._firsts = np.concatenate([[0], np.cumsum(np.bincount(owners, minlength=len(sources) * len(mesh.faces)))])

    def to_vertices(self, source: int) -> Array:
        """(V,) m; only those up to the reach are exact."""
        return self._distances[source * self._count : (source + 1) * self._count]

    def at(self, source: int, points: SurfacePoints) -> Array:
        """(M,) m to surface points; only those up to the reach are exact."""
        return np.minimum(self._from_corners(source, points)[0], self._through_windows(source, points)[0])

    def reaches(self, source: int, goal: SurfacePoints) -> bool:
        """Whether the distance to one surface point is known."""
        distance = float(self.at(source, goal)[0])
        return np.isfinite(distance) and distance <= float(self.reach[source])

    def path(self, source: int, goal: SurfacePoints) -> Array:
        """(M, 3) m from the source to a surface point, bends included; (0, 3) when it is not reached."""
        mesh = self._mesh
        points = [goal.positions(mesh.vertices, mesh.faces)[0]]
        over, vertex = self._from_corners(source, goal)
        through, seen = self._through_windows(source, goal)
        if not np.isfinite(min(over[0], through[0])):
            return np.zeros((0, 3))
        if over[0] < through[0]:
            if vertex[0] == NONE:
                return np.array([self._places[source], points[0]])
            points.append(mesh.vertices[vertex[0]])
            seen = self._seen.chosen(source * self._count + vertex)
        while True:
            window, centre = seen.names[:, 0].tolist()
            points += self._crossings(window, complex(seen.place[0]))
            if centre < len(self._sources):
                return np.array([self._places[source], *points[::-1]])
            points.append(mesh.vertices[self._centres[centre]])
            seen = self._centres_seen.chosen(np.array([centre]))

    def _crossings(self, window: int, place: complex) -> list[Array]:
        """(3,) m each: where the straight line from `place` to its centre crosses the windows on its way."""
        chain = []
        while window != NONE:
            chain.append(window)
            window = int(self._windows.names[2, window])
        if not chain:
            return []
        mesh, edge = self._mesh, self._windows.names[0, chain]
        share = _share(self._windows.plane[0, chain], self._windows.plane[1, chain], np.full(len(chain), place))
        start, end = mesh.vertices[mesh.right[edge]], mesh.vertices[mesh.left[edge]]
        return list(start + share[:, None] * (end - start))

    def _from_corners(self, source: int, points: SurfacePoints) -> tuple[Array, Integers]:
        """(M,) m along the triangles from one of their corners, and which; NONE: from the source itself."""
        mesh = self._mesh
        corners = mesh.faces[points.faces]
        at = np.einsum("mc,mcd->md", points.barycentric, mesh.vertices[corners])
        steps = mesh.vertices[corners] - at[:, None]
        over = self.to_vertices(source)[corners] + np.sqrt(np.einsum("mci,mci->mc", steps, steps))
        chosen = over.argmin(axis=1)
        rows = np.arange(len(points))
        distances, vertices = over[rows, chosen], corners[rows, chosen]
        own = np.flatnonzero(points.faces == self._sources.faces[source])
        straight = np.linalg.norm(at[own] - self._places[source], axis=1)
        nearer = straight <= distances[own]
        distances[own[nearer]], vertices[own[nearer]] = straight[nearer], NONE
        return distances, vertices

    def _through_windows(self, source: int, points: SurfacePoints) -> tuple[Array, _Seen]:
        """(M,) m through the windows of the triangles, inf where there are none, and how they are seen."""
        faces = source * len(self._mesh.faces) + points.faces
        first = self._firsts[faces]
        many = self._firsts[faces + 1] - first
        point = np.repeat(np.arange(len(faces)), many)
        window = self._by_face[np.repeat(first - (np.cumsum(many) - many), many) + np.arange(len(point))]
        edge, centre = self._windows.names[:2, window]
        left, right, to_left, to_right = self._windows.plane[:, window]
        k = edge % 3
        weights = points.barycentric[point, [k, (k + 1) % 3, (k + 2) % 3]]
        place = weights[0] * (left + (right - left) * self._mesh.beyond[edge]) + weights[1] * left + weights[2] * right
        length = np.abs(place)
        inside = _turn(to_right, place) >= -ASIDE * length * np.abs(to_right)
        inside &= _turn(place, to_left) >= -ASIDE * length * np.abs(to_left)
        through = np.where(inside, self._offsets[centre] + length, np.inf)
        best, seen = np.full(len(faces), np.inf), _Seen.directly(len(faces))
        np.minimum.at(best, point, through)
        winners = np.flatnonzero(inside & (through == best[point]))
        seen.put(point[winners], _Seen(np.stack([window, centre]), place), winners)
        return best, seen

    def _first(self, source: int) -> _Windows:
        """The first windows of a source: the edges of its triangle, or all around its vertex."""
        mesh, face, barycentric = self._mesh, int(self._sources.faces[source]), self._sources.barycentric[source]
        corner = int(barycentric.argmax())
        if barycentric[corner] >= 1.0 - AT_CORNER:
            vertex = np.array([mesh.faces[face, corner] + source * self._count])
            self._distances[vertex], self._sent[vertex] = 0.0, -1.0
            self._seen.names[1, vertex] = source
            return self._around(vertex, np.array([source]), everywhere=True)
        edges = 3 * face + np.arange(3)
        plane = mesh.length[edges[2]] * np.array([0.0, 1.0, mesh.beyond[edges[2]]])
        plane = plane - barycentric @ plane
        right, left = np.roll(plane, -1), np.roll(plane, -2)
        incoming = mesh.begins[edges] + np.angle(np.conj(right - plane) * -plane)
        seen = _Seen(np.tile([[NONE], [source]], 3), plane)
        self._note(mesh.apex[edges] + source * self._count, np.abs(plane), incoming, seen)
        entered = mesh.mate[edges]
        names = np.stack([entered, np.full(3, source), np.full(3, NONE), np.full(3, source)])
        return _Windows(names, np.stack([left, right, left, right])).chosen(entered >= 0)

    def _spread(self, windows: list[_Windows]) -> _Windows:
        """Propagates all windows, from those of the sources to the farthest."""
        done: list[_Windows] = []
        now, number = _joined(windows), 0
        while True:
            bent = self._bent()
            now = _joined([now, *bent])
            if now.names.shape[1]:
                done.append(now)
                now, number = self._beyond(now, number), number + now.names.shape[1]
            elif not bent:
                return _joined(done) if done else now

    def _beyond(self, now: _Windows, number: int) -> _Windows:
        """The windows seen through these, the first of which has this number, across their triangles."""
        mesh, d = self._mesh, self._distances
        edge, centre, _, source = now.names
        left, right, to_left, to_right = now.plane
        own, first, offset = np.arange(number, number + len(edge)), source * self._count, self._offsets[centre]
        apex = left + (right - left) * mesh.beyond[edge]
        tip, at_left, at_right = mesh.apex[edge] + first, mesh.left[edge] + first, mesh.right[edge] + first
        past_right, past_left = _turn(to_right, apex), _turn(apex, to_left)
        aside = -ASIDE * np.abs(apex)  # rays right through a vertex must not slip between two windows
        seen = ((past_right >= aside * np.abs(to_right)) & (past_left >= aside * np.abs(to_left))).nonzero()[0]
        if len(seen):
            at, where = apex[seen], edge[seen]
            incoming = mesh.begins[where] + np.angle(np.conj(left[seen] - at) * -at)
            self._note(tip[seen], offset[seen] + np.abs(at), incoming, _Seen(np.stack([own, centre])[:, seen], at))
        # through both other edges: the part on the left of the tip, and the one on its right
        entered = np.concatenate([mesh.beyond_left[edge], mesh.beyond_right[edge]])
        rows = ((np.concatenate([past_left, past_right]) > 0.0) & (entered >= 0)).nonzero()[0]
        on_left = rows < len(edge)
        back = np.where(on_left, rows, rows - len(edge))
        left_end, right_end = np.concatenate([left, apex])[rows], np.concatenate([apex, right])[rows]
        last = np.concatenate([to_left, np.where(past_left > 0.0, apex, to_left)])[rows]
        begin = np.concatenate([np.where(past_right > 0.0, apex, to_right), to_right])[rows]
        names = np.stack([entered[rows], centre[back], own[back], source[back]])
        offset, length = offset[back], mesh.length[names[0]]
        low, high = _share(left_end, right_end, begin), _share(left_end, right_end, last)
        across = left_end - right_end
        low_end, high_end = right_end + low * across, right_end + high * across
        to_low, to_high = offset + np.abs(low_end), offset + np.abs(high_end)
        kept = to_high <= d[np.concatenate([tip, at_right])[rows]] + high * length + SHORTER
        kept &= to_low <= d[np.concatenate([at_left, tip])[rows]] + (1.0 - low) * length + SHORTER
        behind = np.concatenate([right, left])[rows], d[np.concatenate([at_right, at_left])[rows]]
        far, to_far = np.where(on_left, high_end, low_end), np.where(on_left, to_high, to_low)
        kept &= to_far <= behind[1] + np.abs(behind[0] - far) + SHORTER
        reach = self.reach[names[3]]
        foot = -np.real(np.conj(across) * right_end) / np.maximum(length * length, 1e-300)
        nearest = offset + np.abs(right_end + np.clip(foot, low, high) * across)
        if self._goals is not None:
            ends = mesh.vertices[mesh.left[names[0]]] + mesh.vertices[mesh.right[names[0]]]
            missing = 0.5 * ends - self._goals[names[3]]
            nearest += np.maximum(np.sqrt(np.einsum("ni,ni->n", missing, missing)) - 0.5 * length, 0.0)
        kept &= nearest <= reach
        return _Windows(names, np.stack([left_end, right_end, last, begin])).chosen(kept)

    def _note(self, vertices: Integers, distances: Array, incoming: Array, seen: _Seen) -> None:
        """Keeps new distances that are shorter than the known ones."""
        shorter = (distances < self._distances[vertices] - SHORTER).nonzero()[0]
        if len(shorter):
            order = shorter[np.argsort(-distances[shorter], kind="stable")]  # the shortest of each is written last
            where = vertices[order]
            self._distances[where], self._incoming[where] = distances[order], incoming[order]
            self._seen.put(where, seen, order)

    def _bent(self) -> list[_Windows]:
        """The windows of vertices that were reached since the last call and at which paths may bend."""
        reached = self._distances < self._sent
        reached &= self._bends
        vertices = reached.nonzero()[0]
        if not len(vertices):
            return []
        self._sent[vertices] = self._distances[vertices] - SHORTER
        centres = len(self._centres) + np.arange(len(vertices))
        self._centres = np.concatenate([self._centres, vertices % self._count])
        self._offsets = np.concatenate([self._offsets, self._distances[vertices]])
        before, more = self._centres_seen, self._seen.chosen(vertices)
        self._centres_seen = _Seen(
            np.concatenate([before.names, more.names], axis=1), np.concatenate([before.place, more.place])
        )
        return [self._around(vertices, centres)]

    def _around(self, vertices: Integers, centres: Integers, everywhere: bool = False) -> _Windows:
        """The windows of vertices: in their shadows, or everywhere.  Takes note of the neighbours there."""
        mesh = self._mesh
        source, vertex = np.divmod(vertices, self._count)
        firsts, corners_of = mesh.around
        many = firsts[vertex + 1] - firsts[vertex]
        row = np.repeat(np.arange(len(vertices)), many)
        corner = corners_of[np.repeat(firsts[vertex] - (np.cumsum(many) - many), many) + np.arange(len(row))]
        angle, low = mesh.angle[corner], np.zeros(len(corner))
        high = angle
        if not everywhere:
            begins = mesh.begins[corner] - self._incoming[vertices][row]
            total = mesh.total[vertex][row]
            low = np.maximum(np.pi - begins % total, 0.0)
            high = np.minimum(total - np.pi - begins % total, angle)
            if not mesh.closed[vertex].all():  # at a border the shadow has two sides
                open_fan = ~mesh.closed[vertex][row]
                turned = begins < -np.pi
                low = np.where(open_fan, np.where(turned, 0.0, np.maximum(np.pi - begins, 0.0)), low)
                high = np.where(open_fan, np.where(turned, np.minimum(-np.pi - begins, angle), angle), high)
            if mesh.several[vertex].any():
                whole = mesh.several[vertex][row]
                low, high = np.where(whole, 0.0, low), np.where(whole, angle, high)
        shown = ((high >= low - SADDLE) & (low <= angle)).nonzero()[0]
        row, corner, angle, low, high = row[shown], corner[shown], angle[shown], low[shown], high[shown]
        first = corner - corner % 3
        at_right, at_left = first + (corner + 1) % 3, first + (corner + 2) % 3  # the corners that the vertex looks at
        to_right, to_left = mesh.length[at_left], mesh.length[at_right]
        centre, source = centres[row], source[row]
        distance, none = self._distances[vertices][row], np.full(len(row), NONE)
        for inside, length, other, incoming in (
            (low <= SADDLE, to_right, at_right, mesh.begins[at_right] + mesh.angle[at_right]),
            (high >= angle - SADDLE, to_left, at_left, mesh.begins[at_left]),
        ):
            near = inside.nonzero()[0]
            seen = _Seen(np.stack([none, centre])[:, near], length[near] + 0j)
            at = mesh.apex[other[near]] + source[near] * self._count
            self._note(at, distance[near] + length[near], incoming[near], seen)
        entered = mesh.mate[corner]
        plane = np.stack([to_left * np.exp(1j * angle), to_right + 0j, np.exp(1j * high), np.exp(1j * low)])
        return _Windows(np.stack([entered, centre, none, source]), plane).chosen((high > low) & (entered >= 0))


def _turn(u: Complexes, v: Complexes) -> Array:
    """Above zero where v is counter-clockwise of u."""
    return np.asarray(u.real * v.imag - u.imag * v.real)


def _share(left: Complexes, right: Complexes, direction: Complexes) -> Array:
    """(N,) 0 to 1: where rays from the centre meet edges, from their right end to the left one."""
    a, b = _turn(right, direction), _turn(direction, left)
    whole = a + b
    return np.asarray(np.clip(a / np.where(whole > 0.0, whole, 1.0), 0.0, 1.0))
