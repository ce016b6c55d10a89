"""Distances, shortest paths and circles along a triangle mesh, exact on the mesh (fields/distance_field.py).

The heat method would be off by 2 % on the model, and up to 19 mm.  Recent distances, paths and circles are cached, and
points can be named together (`look_from`).  A circle is cut on the triangles that it may cross, split flat.  On a
sphere a tape on chords is too short by about (edge / radius)² / 12.
"""

from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadDrawing
from breastrig.core.lru_cache import LruCache
from breastrig.geometry.closest_point import closest_barycentric
from breastrig.geometry.fields.distance_field import DistanceFields
from breastrig.geometry.fields.level_sets import longest_loop
from breastrig.geometry.half_edges import HalfEdges, split_flat, split_places
from breastrig.geometry.normals import face_crosses
from breastrig.geometry.surface_points import SurfacePoints

RING = 8  # triangles between a circle's centre and its rim, whose chords are as long or shorter: off by radius / 512
MARGIN = 1.01 + 1.0 / RING  # of the radius: what is measured around a circle, both ends of each edge that it crosses
DETOURS = (1.1, 1.4, 2.0, np.inf)  # of the straight line: how long a path may be; the first that is enough counts
TOUCHING = 1e-9  # m, as far as is looked when both ends are at one place
KEPT_FIELDS = 24  # points; a pattern on both sides measures from eight or ten, and each takes about a megabyte
KEPT_LINES = 96  # paths, and as many circles; a pattern has up to forty of either, of some kilobytes each
Key = tuple[int, bytes]


class Geodesics:
    """Measures along one mesh of (V, 3) vertices (m) and (F, 3) triangles."""

    def __init__(self, vertices: Array, faces: Integers) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int64)
        self._fields: LruCache[Key, tuple[DistanceFields, int]] = LruCache(KEPT_FIELDS)
        self._paths: LruCache[tuple[Key, Key], Array] = LruCache(KEPT_LINES)
        self._circles: LruCache[tuple[Key, float], SurfacePoints] = LruCache(KEPT_LINES)

    @cached_property
    def _mesh(self) -> HalfEdges:
        return HalfEdges(self.vertices, self.faces)

    def look_from(self, sources: SurfacePoints, reach: float) -> None:
        """Computes distances from S surface points up to `reach` (m) at once, and caches them for paths and circles."""
        new = [k for k, key in enumerate(_keys(sources)) if not self._known(key, reach)]
        if new:
            asked = sources[new]
            fields = DistanceFields(self._mesh, asked, np.full(len(new), reach))
            for number, key in enumerate(_keys(asked)):
                self._fields.put(key, (fields, number))

    def _known(self, key: Key, reach: float) -> bool:
        known = self._fields.get(key)
        return known is not None and bool(known[0].reach[known[1]] >= reach)

    def _from(self, face: int, barycentric: Array, reach: float) -> tuple[DistanceFields, int]:
        source = SurfacePoints(np.array([face]), np.asarray(barycentric, dtype=np.float64)[None])
        self.look_from(source, reach)
        found = self._fields.get(_keys(source)[0])
        assert found is not None
        return found

    def distances(self, face: int, barycentric: Array, reach: float = np.inf) -> Array:
        """(V,) m from a surface point to each vertex; inf where unconnected or farther than `reach` (m)."""
        fields, number = self._from(face, barycentric, reach)
        found = fields.to_vertices(number).copy()
        found[found > reach] = np.inf
        return found

    def distance(self, a: SurfacePoints, b: SurfacePoints) -> float:
        """m from one surface point to another; inf when no way leads there."""
        straight = float(
            np.linalg.norm((b.positions(self.vertices, self.faces) - a.positions(self.vertices, self.faces))[0])
        )
        for detour in DETOURS:
            fields, number = self._from(int(a.faces[0]), a.barycentric[0], detour * straight + TOUCHING)
            if fields.reaches(number, b):
                return float(fields.at(number, b)[0])
        return float("inf")

    def path(self, a: SurfacePoints, b: SurfacePoints) -> Array:
        """(M, 3) m: the shortest way along the mesh from one surface point to another, bends included.

        BadDrawing when no way leads from a to b.
        """
        return self.paths(a, b)[0]

    def paths(self, a: SurfacePoints, b: SurfacePoints) -> list[Array]:
        """The shortest path from each of K points to its partner; computed together, almost as fast as one."""
        found: dict[int, Array] = {}
        pairs = list(zip(_keys(a), _keys(b), strict=True))
        for k, (start, end) in enumerate(pairs):
            kept = self._paths.get((start, end))
            if kept is not None:
                found[k] = kept
            for key, goal, way in ((start, b[[k]], 1), (end, a[[k]], -1)):
                fields, number = (None, 0) if k in found else self._fields.get(key) or (None, 0)
                if fields is not None and fields.reaches(number, goal):
                    found[k] = fields.path(number, goal)[::way]
        goals = b.positions(self.vertices, self.faces)
        straight = np.linalg.norm(goals - a.positions(self.vertices, self.faces), axis=1)
        for detour in DETOURS:
            left = [k for k in range(len(a)) if k not in found]
            if left:
                fields = DistanceFields(self._mesh, a[left], detour * straight[left] + TOUCHING, goals[left])
                found |= {k: fields.path(n, b[[k]]) for n, k in enumerate(left) if fields.reaches(n, b[[k]])}
        if len(found) < len(a):
            raise BadDrawing("The two points lie on parts of the surface that are not connected; choose others.")
        for k, pair in enumerate(pairs):
            self._paths.put(pair, found[k])
        return [found[k] for k in range(len(a))]

    def circle(self, face: int, barycentric: Array, radius: float) -> Array:
        """(M, 3) m: the closed line of points at `radius` (m) along the mesh, counter-clockwise from outside."""
        return self.circle_points(face, barycentric, radius).positions(self.vertices, self.faces)

    def circle_points(self, face: int, barycentric: Array, radius: float) -> SurfacePoints:
        """The circle as surface points; BadDrawing when it is cut by the end of the surface."""
        key = (int(face), np.asarray(barycentric, dtype=np.float64).tobytes()), float(radius)
        line = self._circles.get(key)
        if line is None:
            line = self._measured_circle(face, barycentric, radius)
            self._circles.put(key, line)
        return line

    def _measured_circle(self, face: int, barycentric: Array, radius: float) -> SurfacePoints:
        fields, number = self._from(face, barycentric, MARGIN * radius)
        reach = float(fields.reach[number])
        source = barycentric @ self.vertices[self.faces[face]]
        measured, mesh = fields.to_vertices(number), self._mesh
        steps = mesh.middles - source
        owners = np.flatnonzero(np.einsum("fi,fi->f", steps, steps) <= (radius + mesh.spans) ** 2)
        vertices, patch, spans = self.vertices, self.faces[owners], mesh.spans[owners]
        places = np.tile(np.eye(3), (len(owners), 1, 1))  # of the triangles' corners, in those of the mesh
        while True:
            least = np.maximum(np.minimum(measured, reach), np.linalg.norm(vertices - source, axis=1))
            near = _may_cross(least, patch, spans, radius)
            patch, owners, places, spans = patch[near], owners[near], places[near], spans[near]
            if spans.max(initial=0.0) <= radius / RING:
                break
            vertices, patch, split = split_flat(vertices, patch)
            spans = 0.5 * spans[split]
            owners, places = owners[split], split_places(places)
            vertices, patch, corner = _compact(vertices, patch)
            measured = fields.at(number, SurfacePoints(owners[corner // 3], places.reshape(-1, 3)[corner]))
        rim = longest_loop(patch, measured, radius)
        if rim is None:
            raise BadDrawing(
                f"A circle of {1e3 * radius:.0f} mm on the skin does not close here: the surface ends before; "
                "choose a smaller radius or another centre."
            )
        line = _on_rim(vertices, rim.edges, measured, radius)
        owners = owners[rim.faces]
        barycentrics = closest_barycentric(line, self.vertices[self.faces[owners]])
        normal = face_crosses(self.vertices, self.faces[[face]])[0]
        if np.cross(line - source, np.roll(line, -1, axis=0) - source).sum(axis=0) @ normal < 0.0:
            owners, barycentrics = owners[::-1], barycentrics[::-1]
        return SurfacePoints(owners, barycentrics)


def _keys(points: SurfacePoints) -> list[Key]:
    return [(int(face), place.tobytes()) for face, place in zip(points.faces, points.barycentric, strict=True)]


def _compact(vertices: Array, faces: Integers) -> tuple[Array, Integers, Integers]:
    """The vertices that the faces use, the faces in their numbers, and one corner (of 3 F) where each stands."""
    used, corner, renumbered = np.unique(faces, return_index=True, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3), corner


def _may_cross(least: Array, faces: Integers, spans: Array, radius: float) -> Booleans:
    """(F,) triangles that a circle may cross, for the least (V,) m of their corners, exact up to the radius."""
    off = np.abs(least - radius)
    a, b, c = faces.T
    return np.asarray((off[a] <= spans) & (off[b] <= spans) & (off[c] <= spans))


def _on_rim(vertices: Array, edges: Integers, distances: Array, radius: float) -> Array:
    """(M, 3) m: where (M, 2) edges are `radius` from the source.

    Unfolded into the plane of the source, the distance along an edge of length L obeys
    d²(s) = (1 − s) d²(0) + s d²(1) − s (1 − s) L²; one of its roots lies between ends of which one is nearer.
    """
    a, b = vertices[edges[:, 0]], vertices[edges[:, 1]]
    square = np.einsum("mi,mi->m", b - a, b - a)
    first, second = distances[edges[:, 0]] ** 2, distances[edges[:, 1]] ** 2
    linear, constant = second - first - square, first - radius**2
    root = np.sqrt(np.maximum(linear**2 - 4.0 * square * constant, 0.0))
    leaving = (-linear + root) / (2.0 * square)
    entering = (-linear - root) / (2.0 * square)
    share = np.clip(np.where(first < second, leaving, entering), 0.0, 1.0)
    return np.asarray(a + share[:, None] * (b - a))
