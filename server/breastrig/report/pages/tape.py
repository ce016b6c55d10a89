"""The tape sheet: where the plan's key points lie, so that it can be drawn again with a tape measure and no screen.

Of each key point stand its distances along the skin from three landmarks that are easily found.  Two arcs on the skin
meet in two places, a third says in which.  Of all triples that one is taken which leaves the point least uncertain:
each landmark may be off by its own radius, and each length is read off along one direction of the skin (the linearised
error of trilateration, as dilution of precision in geodesy).  Picked landmarks come first.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.normals import face_normals, unit_vectors
from breastrig.geometry.polyline import Polyline, arc_lengths, interpolated, length
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.report.body_frame import BodyFrame, body_frame
from breastrig.report.stance import Place, Stance, places

FOUND = (  # by eye or finger on anybody; folds and shoulders are long, the middle of the breastbone is measured itself
    "suprasternal_notch", "midclavicle_L", "midclavicle_R", "xiphoid", "nipple_L", "nipple_R", "umbilicus",
)  # fmt: skip
THREE = 3
NEAREST = 0.02  # m; nearer the tape is as long as the error of the landmark
SAME = 0.003  # m; what is as near is one point, as a tape is read
CIRCULAR = 0.985  # 4 pi area over the outline's square: circles on breasts have 0.990 and more, rounded patterns 0.946
POINT, LARGEST = 0.005, 0.05  # m, radius up to which any closed line is one point, and a circle is drawn by its centre
ASSUMED = {"model": 0.015}  # m, radius of a landmark of which none is known, only to choose by; picked ones PICKED
PICKED = 0.005
READ, LAID = 0.002, 0.01  # m, and share of its length, by which a tape is read and laid wrongly; nobody measured it
NINE_OF_TEN = float(np.sqrt(-2.0 * np.log(0.1)))  # radius over standard deviation, of a normal spread on a plane
ARM = 0.008  # m to both sides of a point, over which it is seen how sharply the line turns there
SHARP = 40.0  # degrees; a keyhole of 42 mm turns by 22 over two arms


@dataclass(frozen=True, eq=False)
class TapePoint:
    """A key point of a line."""

    line: str
    point: str  # upper, lower, medial, lateral, start, end, centre ...
    at: Array  # (3,) m
    lengths_mm: tuple[tuple[str, float], ...]  # (landmark, along the skin), the nearest first; none where the skin ends
    error_mm: float | None  # radius that holds the true place with 90 %
    radius_mm: float | None = None  # of a circle, along the skin
    around: str = ""  # the landmark that is a circle's centre


def tape_points(stance: Stance) -> list[TapePoint]:
    """The key points of all lines, in their order; a place that several lines share once."""
    frame = body_frame(stance.rig, stance.vertices)
    known = {name: place for name, place in places(stance).items() if name in FOUND}
    picked = {name: place for name, place in known.items() if place.source != "model"}
    starts = picked if len(picked) >= THREE else known
    if not stance.lines or len(known) < THREE:
        return []
    geodesics = Geodesics(stance.vertices, stance.rig.faces)
    asked: list[TapePoint] = []
    for line in stance.lines:
        for point in _of_line(stance, line, frame, geodesics, known):
            if all(np.linalg.norm(point.at - other.at) > SAME or point.radius_mm for other in asked):
                asked.append(point)
    on_skin = stance.on_model(np.array([point.at for point in asked]))
    normals = face_normals(stance.vertices, stance.rig.faces)[on_skin.faces]
    chosen = [
        () if point.around else _triple(point.at, normal, starts) for point, normal in zip(asked, normals, strict=True)
    ]
    lengths = _lengths(stance, geodesics, on_skin, starts, chosen)
    return [
        replace(
            point,
            lengths_mm=tuple(sorted(((n, 1e3 * far) for n, far in found.items()), key=lambda each: each[1])),
            error_mm=_error(point, normal, [starts[name] for name in found]) if found else point.error_mm,
        )
        for point, normal, found in zip(asked, normals, lengths, strict=True)
    ]


def _of_line(
    stance: Stance, line: Polyline, frame: BodyFrame, geodesics: Geodesics, known: Mapping[str, Place]
) -> list[TapePoint]:
    """A line's key points with its own errors; of a circle only its centre."""
    key = key_points(line, frame)
    centre = _centre(line)
    if centre is None:
        return [TapePoint(line.name, name, line.points[k], (), _own(line, [k])) for name, k in key]
    error = _own(line, range(len(line.points)))
    rim = stance.on_model(line.points[[k for _, k in key]])
    near = min(known.values(), key=lambda place: float(np.linalg.norm(place.point - centre)))
    radii = _radii(stance, geodesics, near.point, rim)
    if np.ptp(radii) < SAME:
        return [TapePoint(line.name, "centre", near.point, (), error, 1e3 * float(np.median(radii)), near.name)]
    radius = 1e3 * float(np.median(_radii(stance, geodesics, centre, rim)))
    return [TapePoint(line.name, "centre", stance.search.query(centre[None]).points[0], (), error, radius)]


def _radii(stance: Stance, geodesics: Geodesics, centre: Array, rim: SurfacePoints) -> Array:
    """(P,) m along the skin from a (3,) m place to the rim; infinite where the skin ends between them."""
    start = stance.on_model(np.repeat(centre[None], len(rim.faces), axis=0))
    try:
        return np.array([length(way) for way in geodesics.paths(start, rim)])
    except BadDrawing:
        return np.full(len(rim.faces), np.inf)


def _centre(line: Polyline) -> Array | None:
    """(3,) m: the centre of a circle on the skin; None for other lines."""
    if not line.closed or len(line.points) < 2 * THREE:
        return None
    centre = np.asarray(line.points.mean(axis=0))
    arms = line.points - centre
    radius = float(np.linalg.norm(arms, axis=1).mean())
    twice = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)  # the vector of twice the area: seen from there
    seen = arms - np.outer(arms @ twice, twice) / float(twice @ twice)
    outline = float(np.linalg.norm(seen - np.roll(seen, -1, axis=0), axis=1).sum())
    is_circle = 2.0 * np.pi * np.linalg.norm(twice) > CIRCULAR * outline**2 and radius < LARGEST
    return centre if radius < POINT or is_circle else None


def key_points(line: Polyline, frame: BodyFrame) -> list[tuple[str, int]]:
    """(name, index of the point): of a closed line its four extremes, of an open one its ends, corners and middle."""
    points = line.points
    if len(points) == 1:
        return [("place", 0)]
    height, side = frame.height(points), frame.lateral(points)
    outward = np.abs(side) if np.ptp(np.sign(side[np.abs(side) > 1e-9])) == 0.0 else side
    extremes = {
        "upper": int(height.argmax()),
        "lower": int(height.argmin()),
        "medial" if outward is not side else "right": int(outward.argmin()),
        "lateral" if outward is not side else "left": int(outward.argmax()),
    }
    if line.closed:
        return list(extremes.items())
    ends = {"start": 0, "end": len(points) - 1}
    corners = {f"corner {number}": corner for number, corner in enumerate(line.corners or sharp_turns(points), 1)}
    middle = {} if corners or len(points) < THREE else {"middle": len(points) // 2}
    return [*ends.items(), *corners.items(), *middle.items()]


def sharp_turns(points: Array) -> list[int]:
    """Indices at which an open line of (P, 3) m points turns sharply, not counting its ends."""
    along = arc_lengths(points)
    before = interpolated(along - ARM, along, points)
    after = interpolated(along + ARM, along, points)
    turn = np.degrees(
        np.arccos(np.clip(np.einsum("pi,pi->p", unit_vectors(points - before), unit_vectors(after - points)), -1, 1))
    )
    turn[(along < ARM) | (along > along[-1] - ARM)] = 0.0
    found: list[int] = []
    for k in np.argsort(-turn):
        if turn[k] < SHARP:
            break
        if all(abs(along[k] - along[other]) > 2.0 * ARM for other in found):
            found.append(int(k))
    return sorted(found)


def _triple(point: Array, normal: Array, starts: Mapping[str, Place]) -> tuple[str, ...]:
    """The three landmarks, not too near, from which the tape leaves the point least uncertain."""
    far = [name for name, place in starts.items() if np.linalg.norm(place.point - point) > NEAREST]
    triples = combinations(far, THREE) if len(far) > THREE else [tuple(far)]
    return min(triples, key=lambda three: _spread(point, normal, [starts[name] for name in three]))


def _spread(point: Array, normal: Array, marks: Sequence[Place]) -> float:
    """m, radius that holds the point with 90 %, as the landmarks' own radii leave it; infinite where the arcs touch."""
    way = np.array([mark.point for mark in marks]) - point
    far = np.linalg.norm(way, axis=1)
    flat = unit_vectors(way - (way @ normal)[:, None] * normal)
    off = [ASSUMED.get(mark.source, PICKED) if mark.radius is None else mark.radius for mark in marks]
    variances = (np.square(off) + np.square(READ + LAID * far)) / NINE_OF_TEN**2
    information = flat.T @ (flat / variances[:, None]) + np.outer(normal, normal)  # the point stays on the skin
    if np.linalg.det(information * variances.min()) < 1e-6:
        return float("inf")
    return NINE_OF_TEN * float(np.sqrt(0.5 * (np.trace(np.linalg.inv(information)) - 1.0)))


def _error(point: TapePoint, normal: Array, marks: Sequence[Place]) -> float | None:
    """The point's error, mm, from the landmarks and the line; None where a landmark's radius is not known."""
    spread = _spread(point.at, normal, marks)
    if not np.isfinite(spread) or any(mark.radius is None for mark in marks):
        return None
    return float(np.hypot(1e3 * spread, point.error_mm or 0.0))


def _lengths(
    stance: Stance,
    geodesics: Geodesics,
    points: SurfacePoints,
    starts: Mapping[str, Place],
    chosen: Sequence[Sequence[str]],
) -> list[dict[str, float]]:
    """For each point {landmark: m along the skin}."""
    names = list(starts)
    marks = stance.on_model(np.array([place.point for place in starts.values()]))
    pairs = [(k, names.index(name)) for k, three in enumerate(chosen) for name in three]
    found: list[dict[str, float]] = [{} for _ in chosen]
    together = [pairs]  # takes a third of the time of one landmark after the other
    while together:
        asked = together.pop()
        if not asked:
            continue
        at, to = [k for k, _ in asked], [mark for _, mark in asked]
        try:
            for (k, mark), way in zip(asked, geodesics.paths(marks[to], points[at]), strict=True):
                found[k][names[mark]] = length(way)
        except BadDrawing:  # the skin ends between two of them
            together += [[pair] for pair in asked] if len(asked) > 1 else []
    return found


def _own(line: Polyline, where: Sequence[int]) -> float | None:
    """The line's own error there, mm; None where it is unknown, or where the line was drawn."""
    if line.error is None:
        return None
    known = line.error[list(where)]
    known = known[np.isfinite(known)]
    return 1e3 * float(known.mean()) if len(known) else None
