"""Projects a drawing of the fitted model onto the scan.

Each polyline is resampled evenly on the posed model; its ends and marked corners stay.  Rays along the model's normal
find the scan's skin, else the closest point that faces the same way.  The gaps from model to skin are smoothed along
the line, not the points, which would shrink circles:

* a gap beyond TRUSTED counts only where it grows steadily from trusted neighbours, else the ray met another surface;
* over holes of the scan the line follows the model, the gaps fading from border to border.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import unit_vectors, vertex_normals
from breastrig.geometry.polyline import Polyline, interpolated, resampled
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig

SPACING = 0.003  # m; finer than a pen, coarser than the noise
FEWEST = 24  # points of a closed line, however small: a marked nipple is a circle, not a hexagon
ROUNDED_UP = 1.0 + 1e-9  # or the last digit decides whether a small circle has one point more
ON_SKIN = (
    MatchRules(method="rays", max_distance=0.03, max_angle=np.pi / 3),
    MatchRules(method="tree", max_distance=0.02, max_angle=np.pi / 3),
)
TRUSTED = 0.010  # m, a gap that a good fit shows anywhere; arms and tables are farther behind
STEP = 0.003  # m, by which a larger gap may differ from its neighbour's: a slope of 45 degrees at SPACING
FADE = 0.05  # m, over which a gap fades beyond the last known one of an open line
ROUNDS = 6  # of smoothing: the gaps' noise falls to a third, waves longer than 30 mm stay
SLIP = 0.004  # m, the farthest that a smoothed point may be snapped; farther is another sheet


def on_scan(rig: Rig, vertices: Array, drawing: ModelDrawing, target: ScanTarget) -> tuple[Polyline, ...]:
    """The drawing on the scan, for (V, 3) m posed vertices in the target's frame.

    All its lines go through each step together: asking for the skin below them once costs less than line by line.
    """
    return shapes_on_scan(rig, vertices, vertex_normals(vertices, rig.faces), drawing.shapes, target)


def shapes_on_scan(
    rig: Rig, vertices: Array, normals: Array, shapes: Sequence[DrawnShape], target: ScanTarget
) -> tuple[Polyline, ...]:
    """The shapes on the scan, given the posed vertices' (V, 3) unit normals."""
    if not shapes:
        return ()
    even = [_on_model(rig, vertices, normals, shape) for shape in shapes]
    ends = _ends([line for line, _ in even])
    base = np.concatenate([line[:, :3] for line, _ in even])
    directions = unit_vectors(np.concatenate([line[:, 3:] for line, _ in even]))
    gaps, known = _gaps(target, base, directions)
    parts = zip(*(np.split(each, ends) for each in (base, directions, gaps)), np.split(known, ends), strict=True)
    lines = [
        LineNearSkin(here, facing, gap, there, fixed, shape.closed)
        for (here, facing, gap, there), (_, fixed), shape in zip(parts, even, shapes, strict=True)
    ]
    # on the scan the spacing is no longer quite even
    again = [
        _resampled(
            np.concatenate([points, line.directions, ~known[:, None]], axis=1),
            tuple(np.flatnonzero(line.fixed).tolist()),
            line.closed,
        )
        for line, (points, known) in zip(lines, smoothed_on_skin(target, lines), strict=True)
    ]
    ends = _ends([line for line, _ in again])
    every = np.concatenate([line for line, _ in again])
    found, known = _snapped(target, every[:, :3], unit_vectors(every[:, 3:6]), every[:, 6] < 1e-9)
    each = zip(shapes, np.split(found, ends), np.split(known, ends), again, strict=True)
    return tuple(_polyline(shape, points, there, fixed) for shape, points, there, (_, fixed) in each)


def _on_model(rig: Rig, vertices: Array, normals: Array, shape: DrawnShape) -> tuple[Array, Booleans]:
    """(M, 6) places (m) and normals evenly along the shape, and (M,) its corners and ends."""
    both = [shape.points.positions(each, rig.faces) for each in (vertices, normals)]
    return _resampled(np.concatenate(both, axis=1), shape.corners, shape.closed)


def _ends(lines: Sequence[Array]) -> Integers:
    """End indices of all lines but the last when they are concatenated."""
    return np.cumsum([len(line) for line in lines])[:-1]


def _polyline(shape: DrawnShape, points: Array, known: Booleans, fixed: Booleans) -> Polyline:
    corners = np.flatnonzero(fixed).tolist()
    ends = () if shape.closed else (0, len(points) - 1)
    turning = tuple(corner for corner in corners if corner not in ends)
    return Polyline(shape.name, shape.closed, shape.color, points, ~known, turning)


@dataclass(frozen=True, eq=False)
class LineNearSkin:
    """A line and its gaps to the skin, not yet smoothed."""

    base: Array  # (M, 3) m
    directions: Array  # (M, 3) unit, out of the skin
    gaps: Array  # (M, 3) m, from the line to the skin
    known: Booleans  # (M,) where there is skin
    fixed: Booleans  # (M,) points that are not smoothed
    closed: bool


def smoothed_on_skin(target: ScanTarget, lines: Sequence[LineNearSkin]) -> list[tuple[Array, Booleans]]:
    """(M, 3) m points on the skin for each line, and which of its points lie there.

    All lines go through the rounds together: one query of the skin costs less than one per line.
    """
    known = [
        each.known & _reliable(np.einsum("mi,mi->m", each.gaps, each.directions), each.known, each.closed)
        for each in lines
    ]
    gaps = [_interpolated(each.base, each.gaps, here, each.closed) for each, here in zip(lines, known, strict=True)]
    ends = _ends([each.base for each in lines])
    base, directions = (np.concatenate([getattr(s, name) for s in lines]) for name in ("base", "directions"))
    there = np.concatenate(known)
    for _ in range(ROUNDS):
        smooth = [_smoothed(gap, each.fixed, each.closed) for gap, each in zip(gaps, lines, strict=True)]
        points, there = _snapped(target, base + np.concatenate(smooth), directions, there)
        gaps = np.split(points - base, ends)
    return list(zip(np.split(points, ends), np.split(there, ends), strict=True))


def _resampled(line: Array, corners: tuple[int, ...], closed: bool) -> tuple[Array, Booleans]:
    """The (M, D) line resampled between its corners, and which points are corners or ends."""
    if len(line) < 2:
        return line, np.ones(len(line), dtype=np.bool_)
    stops = sorted({corner for corner in corners if 0 <= corner < len(line)})
    if closed and not stops:
        around = np.linalg.norm(np.roll(line[:, :3], -1, axis=0) - line[:, :3], axis=1).sum()
        fewest = float(around) / FEWEST * ROUNDED_UP
        even = resampled(line, min(SPACING, fewest), True)
        return even, np.zeros(len(even), dtype=np.bool_)
    if closed:
        line = np.concatenate([line[stops[0] :], line[: stops[0] + 1]])
        stops = [stop - stops[0] for stop in stops]
    stops = sorted({0, *stops, len(line) - 1})
    pieces = [resampled(line[a : b + 1], SPACING, False) for a, b in pairwise(stops)]
    even = np.concatenate([*(piece[:-1] for piece in pieces), pieces[-1][-1:]])
    fixed = np.zeros(len(even), dtype=np.bool_)
    fixed[np.cumsum([0, *(len(piece) - 1 for piece in pieces)])] = True
    return (even[:-1], fixed[:-1]) if closed else (even, fixed)


def _gaps(target: ScanTarget, base: Array, directions: Array) -> tuple[Array, Booleans]:
    """(M, 3) m from the model to the skin, and where one was found."""
    gaps = np.zeros_like(base)
    missing = np.arange(len(base))
    for rules in ON_SKIN:
        found = match(target, base[missing], directions[missing], rules)
        hit = missing[found.vertices]
        gaps[hit] = found.points - base[hit]
        missing = np.delete(missing, found.vertices)
    known = np.ones(len(base), dtype=np.bool_)
    known[missing] = False
    return gaps, known


def _reliable(heights: Array, known: Booleans, closed: bool) -> Booleans:
    """(M,) known gaps that are small, or that are reached from small ones without a hole or a step."""
    good = known & (np.abs(heights) <= TRUSTED)
    while True:
        grown = good.copy()
        for way in (1, -1):
            reached = np.roll(good, way) & known & (np.abs(heights - np.roll(heights, way)) <= STEP)
            if not closed:
                reached[0 if way == 1 else -1] = False
            grown |= reached
        if (grown == good).all():
            return good
        good = grown


def _interpolated(base: Array, gaps: Array, known: Booleans, closed: bool) -> Array:
    """(M, 3) m: unknown gaps between those at the borders of their hole, by the length along the model."""
    if known.all() or not known.any():
        return np.where(known[:, None], gaps, 0.0)
    steps = np.linalg.norm(np.roll(base, -1, axis=0) - base, axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at, places, values = along[:-1], along[:-1][known], gaps[known]
    if closed:
        places = np.concatenate([places - along[-1], places, places + along[-1]])
        values = np.tile(values, (3, 1))
    filled = interpolated(at, places, values)
    beyond = np.maximum(np.maximum(places[0] - at, at - places[-1]), 0.0)
    return np.where(known[:, None], gaps, filled * np.clip(1.0 - beyond / FADE, 0.0, 1.0)[:, None])


def _smoothed(gaps: Array, fixed: Booleans, closed: bool) -> Array:
    """One round of averaging with the neighbours; fixed points stay."""
    if len(gaps) < 3:
        return gaps
    middle = 0.5 * gaps + 0.25 * (np.roll(gaps, 1, axis=0) + np.roll(gaps, -1, axis=0))
    keep = fixed.copy()
    if not closed:
        keep[[0, -1]] = True
    return np.where(keep[:, None], gaps, middle)


def _snapped(target: ScanTarget, points: Array, directions: Array, known: Booleans) -> tuple[Array, Booleans]:
    """Known points snapped to the skin; those that would slip too far or turn over are no longer known."""
    points, known = points.copy(), known.copy()
    rows: Integers = np.flatnonzero(known)
    if len(rows) == 0:
        return points, known
    found = target.search.query(points[rows])
    _, normals, _ = target.surface_at(found.faces, found.barycentric)
    good = (found.distances <= SLIP) & (np.einsum("mi,mi->m", normals, directions[rows]) > 0.0)
    points[rows[good]] = found.points[good]
    known[rows[~good]] = False
    return points, known
