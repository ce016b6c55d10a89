"""Openings of a surface closed with flat-as-can-be caps of well-shaped triangles, as a tetrahedral mesher wants them.

Each border loop is filled in the plane of its area: points of a hexagonal grid with the rim's own spacing, triangulated
(Delaunay), relaxed, and lifted by the smoothest heights between the rim's.  A fan around the centre would do for
looking, but its triangles are needles.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import Delaunay, QhullError

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_edges, boundary_loops
from breastrig.geometry.half_edges import neighbours

CLEARANCE = 0.65  # of the spacing, between a rim and the grid inside it: nearer gives flat triangles
ROUNDS = 12  # of moving each inner point to the middle of its neighbours


@dataclass(frozen=True, eq=False)
class Closed:
    """A surface without openings; its first vertices and triangles are the given ones."""

    vertices: Array  # (W, 3) m
    faces: Integers  # (G, 3) counter-clockwise from outside
    caps: tuple[Integers, ...]  # for each opening, the longest rim first: its triangles


def closed(vertices: Array, faces: Integers) -> Closed:
    """(V, 3) m vertices and (F, 3) triangles with every opening capped; ValueError for borders that do not close."""
    points, triangles = [vertices], [faces]
    count, made = len(vertices), len(faces)
    caps = []
    for loop in boundary_loops(faces):
        inner, cap = cap_of(vertices[loop])
        numbers = np.concatenate([loop, count + np.arange(len(inner))])
        points.append(inner)
        triangles.append(numbers[cap])
        caps.append(made + np.arange(len(cap), dtype=np.int64))
        count, made = count + len(inner), made + len(cap)
    return Closed(np.concatenate(points), np.concatenate(triangles), tuple(caps))


def walled(inner: Array, outer: Array, faces: Integers) -> tuple[Array, Integers]:
    """The closed surface between two (V, 3) m places of an open one, `outer` on the side that its triangles face."""
    count = len(inner)
    a, b = boundary_edges(faces).T
    walls = [np.stack([b + count, a + count, a], axis=1), np.stack([b + count, a, b], axis=1)]
    return np.concatenate([inner, outer]), np.concatenate([faces[:, ::-1], faces + count, *walls])


def cap_of(rim: Array) -> tuple[Array, Integers]:
    """((I, 3) m inner points, (C, 3) triangles of rim points 0 … M-1 and inner points M …) for a (M, 3) m rim.

    The rim runs as the border of the surface does; the triangles face away from that surface.
    """
    flat, heights, axes, middle = _flattened(rim)
    spacing = float(np.median(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)))
    inner = _grid(flat, spacing)
    triangles = _triangulated(flat, inner)
    for _ in range(ROUNDS if len(inner) else 0):
        moved = (neighbours(triangles, len(flat) + len(inner)) @ np.concatenate([flat, inner]))[len(flat) :]
        again = _triangulated(flat, moved)
        if not _keeps_rim(again, len(flat)):
            break
        inner, triangles = moved, again
    if not _keeps_rim(triangles, len(flat)):
        return _fan(rim)
    level = _smooth_heights(triangles, heights, len(inner))
    points = np.column_stack([inner, level]) @ axes.T + middle
    return points, triangles[:, ::-1]


def _flattened(rim: Array) -> tuple[Array, Array, Array, Array]:
    """(M, 2) in the plane of the rim's area, counter-clockwise; (M,) heights; the axes (columns) and the middle."""
    middle = rim.mean(axis=0)
    arms = rim - middle
    normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    normal /= np.linalg.norm(normal)
    across = arms[0] - normal * (arms[0] @ normal)
    across /= np.linalg.norm(across)
    axes = np.stack([across, np.cross(normal, across), normal], axis=1)
    local = arms @ axes
    return local[:, :2], local[:, 2], axes, middle


def _grid(polygon: Array, spacing: float) -> Array:
    """(I, 2) points of a hexagonal grid inside the polygon and not near its rim."""
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    rows = np.arange(low[1], high[1], spacing * np.sqrt(0.75))
    columns = np.arange(low[0], high[0] + spacing, spacing)
    points = np.array([[x + 0.5 * spacing * (k % 2), y] for k, y in enumerate(rows) for x in columns]).reshape(-1, 2)
    ends = np.roll(polygon, -1, axis=0)
    along = ends - polygon
    share = np.einsum("psi,si->ps", points[:, None] - polygon, along) / np.maximum((along**2).sum(axis=1), 1e-30)
    nearest = polygon + np.clip(share, 0.0, 1.0)[..., None] * along
    gaps = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
    return np.asarray(points[_inside(points, polygon) & (gaps > CLEARANCE * spacing)])


def _inside(points: Array, polygon: Array) -> Booleans:
    """(P,) whether a ray to the right crosses the polygon's sides an odd number of times."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    at = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray((spans & (x < at)).sum(axis=1) % 2 == 1)


def _triangulated(polygon: Array, inner: Array) -> Integers:
    """(C, 3) counter-clockwise triangles of the polygon's points and the inner ones; none when they lie on a line."""
    points = np.concatenate([polygon, inner])
    try:
        triangles = Delaunay(points).simplices.astype(np.int64)
    except QhullError:
        return np.zeros((0, 3), dtype=np.int64)
    a, b, c = points[triangles].transpose(1, 0, 2)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((area < 0.0)[:, None], triangles[:, ::-1], triangles)
    return np.asarray(triangles[_inside((a + b + c) / 3.0, polygon)])


def _keeps_rim(triangles: Integers, count: int) -> bool:
    """Whether the triangles' border is the rim 0 … count-1, each edge once and in its direction."""
    try:
        loops = boundary_loops(triangles)
    except ValueError:
        return False
    if len(loops) != 1 or len(loops[0]) != count:
        return False
    turned = np.roll(loops[0], -int(loops[0].argmin()))
    return bool((turned == np.arange(count)).all())


def _smooth_heights(triangles: Integers, rim: Array, inner: int) -> Array:
    """(inner,) each the mean of its neighbours."""
    if not inner:
        return np.zeros(0)
    count = len(rim)
    rows = neighbours(triangles, count + inner)[count:]
    here = diags_array(np.ones(inner)) - rows[:, count:]
    return np.atleast_1d(np.asarray(spsolve(here.tocsc(), rows[:, :count] @ rim)))


def _fan(rim: Array) -> tuple[Array, Integers]:
    """Triangles from a rim to its middle, for rims that fold over themselves."""
    count = len(rim)
    first = np.arange(count, dtype=np.int64)
    after = (first + 1) % count
    return rim.mean(axis=0)[None], np.stack([after, first, np.full(count, count)], axis=1)
