"""The tape sheet: where the drawing's key points lie, so that it can be drawn again with a tape measure and no screen.

Of each key point stand its distances along the skin from three landmarks that are easily found.  Two arcs on the skin
meet in two places, a third says in which; so landmarks are near, and look at the point from different sides.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.geometry.geodesic import Geodesics, length
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.geometry.unit_vectors import unit_vectors
from breastrig.report.body_frame import BodyFrame, body_frame
from breastrig.report.stance import Stance, places

FOUND = (  # by eye or finger on anybody; folds and shoulders are long, the middle of the breastbone is measured itself
    "suprasternal_notch", "midclavicle_L", "midclavicle_R", "xiphoid", "nipple_L", "nipple_R", "umbilicus",
)  # fmt: skip
THREE = 3
NEAREST = 0.02  # m; nearer the tape is as long as the error of the landmark
APART = np.cos(np.radians(25.0))  # of the directions to two landmarks: closer together their arcs nearly touch
ARM = 0.008  # m to both sides of a point, over which it is seen how sharply the line turns there
SHARP = 40.0  # degrees; a keyhole of 42 mm turns by 22 over two arms
NEAR = 5  # of the landmarks that are looked at


@dataclass(frozen=True)
class TapePoint:
    """A key point of a line."""

    line: str
    point: str  # upper, lower, medial, lateral, start, end ...
    lengths_mm: tuple[tuple[str, float], ...]  # (landmark, along the skin), the nearest first; none where the skin ends
    error_mm: float | None  # radius that holds the true place with 90 %


def tape_points(stance: Stance) -> list[TapePoint]:
    """Of all lines, in their order."""
    frame = body_frame(stance.rig, stance.vertices)
    asked = [(line, name, k) for line in stance.lines for name, k in key_points(line, frame)]
    known = [place for name, place in places(stance).items() if name in FOUND]
    if not asked or len(known) < THREE:
        return []
    at = np.array([line.points[k] for line, _, k in asked])
    on_skin, marks = stance.on_model(at), stance.on_model(np.array([place.point for place in known]))
    chosen = [_triple(point, np.array([place.point for place in known])) for point in at]
    lengths = _lengths(stance, on_skin, marks, chosen)
    return [
        TapePoint(
            line.name,
            name,
            tuple((known[mark].name, 1e3 * found[mark]) for mark in sorted(found, key=lambda mark: found[mark])),
            _error(stance, line, k),
        )
        for (line, name, k), found in zip(asked, lengths, strict=True)
    ]


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
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    before = np.stack([np.interp(along - ARM, along, points[:, axis]) for axis in range(3)], axis=1)
    after = np.stack([np.interp(along + ARM, along, points[:, axis]) for axis in range(3)], axis=1)
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


def _triple(point: Array, marks: Array) -> list[int]:
    """Three of the (L, 3) m landmarks: near, and not behind each other as seen from the point."""
    way = marks - point
    far = np.linalg.norm(way, axis=1)
    order = [int(k) for k in np.argsort(far) if far[k] > NEAREST][:NEAR]
    unit = way / np.maximum(far, 1e-9)[:, None]

    def cost(three: Iterable[int]) -> tuple[bool, float]:
        chosen = list(three)
        same = any(float(unit[a] @ unit[b]) > APART for a, b in combinations(chosen, 2))
        return same, float(far[chosen].sum())

    return list(min(combinations(order, THREE), key=cost)) if len(order) >= THREE else order


def _lengths(
    stance: Stance, points: SurfacePoints, marks: SurfacePoints, chosen: Sequence[Sequence[int]]
) -> list[dict[int, float]]:
    """For each point {landmark: m along the skin}."""
    geodesics = Geodesics(stance.vertices, stance.rig.faces)
    pairs = [(k, mark) for k, three in enumerate(chosen) for mark in three]
    found: list[dict[int, float]] = [{} for _ in chosen]
    together = [pairs]  # takes a third of the time of one landmark after the other
    while together:
        asked = together.pop()
        at, to = [k for k, _ in asked], [mark for _, mark in asked]
        start = SurfacePoints(marks.faces[to], marks.barycentric[to])
        goal = SurfacePoints(points.faces[at], points.barycentric[at])
        try:
            for (k, mark), way in zip(asked, geodesics.paths(start, goal), strict=True):
                found[k][mark] = length(way)
        except BadDrawing:  # the skin ends between two of them
            together += [[pair] for pair in asked] if len(asked) > 1 else []
    return found


def _error(stance: Stance, line: Polyline, k: int) -> float | None:
    if line.error is not None:
        return 1e3 * float(line.error[k]) if np.isfinite(line.error[k]) else None
    return None
