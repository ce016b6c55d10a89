"""The tape sheet as the report's template sets it: a picture with numbered points, and a row of lengths for each."""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.rendering.picture import Camera, camera
from breastrig.report.body_frame import body_frame
from breastrig.report.pages.names import spoken
from breastrig.report.pages.tape import TapePoint, tape_points
from breastrig.report.pictures import jpeg, scan_pictures
from breastrig.report.stance import Stance, places

SIZE = (180.0, 105.0)  # mm of the picture
PIXELS_PER_MM = 6.0
MARGIN = 0.08  # share of the picture around the outermost point
BESIDE = 3.0  # mm from a point to its number
STEPS = 40  # of pushing numbers apart
ROOM = (4.2, 3.0)  # mm that a number takes


def tape_sheet(name: str, stance: Stance) -> dict[str, Any] | None:
    """The sheet's data; None where nothing is drawn, or the rig has too few landmarks."""
    points = tape_points(stance)
    if not points:
        return None
    known = places(stance)
    used = [mark for mark in known if any(mark in (n for n, _ in point.lengths_mm) for point in points)]
    letters = dict(zip(used, "ABCDEFGHIJ", strict=False))
    shown = np.array([*(point.at for point in points), *(known[mark].point for mark in used)])
    view = camera("front", shown, body_frame(stance.rig, stance.vertices).axes, SIZE[0] / SIZE[1], margin=MARGIN)
    size = round(PIXELS_PER_MM * SIZE[0]), round(PIXELS_PER_MM * SIZE[1])
    [picture] = scan_pictures(stance, [view], size)
    places_mm = _on_paper(view, shown)
    numbers = [str(k + 1) for k in range(len(points))]
    rows: list[dict[str, Any]] = []
    for number, point in zip(numbers, points, strict=True):
        rows.append(
            {
                "number": number,
                "line": "" if rows and rows[-1]["of"] == point.line else spoken(point.line),
                "of": point.line,
                "point": _words(point),
                "lengths": [[letters[mark], spoken(mark), f"{mm:.0f}"] for mark, mm in point.lengths_mm],
                "error": "" if point.error_mm is None or point.around else f"±{point.error_mm:.0f}",
            }
        )
    return {
        "stance": name,
        "predicted": stance.predicted,
        "picture": list(jpeg(picture)),
        "size": list(SIZE),
        "dots": _dots(places_mm, [*numbers, *letters.values()], len(points)),
        "landmarks": [[letters[mark], spoken(mark), known[mark].source, off_by(known[mark].radius)] for mark in used],
        "rows": rows,
    }


def _words(point: TapePoint) -> str:
    if point.radius_mm is None:
        return point.point
    where = f"around the {spoken(point.around).lower()}" if point.around else point.point
    return f"{where}, radius {point.radius_mm:.0f} mm"


def off_by(metres: float | None) -> str:
    """±6 mm."""
    return "not known" if metres is None else f"±{1e3 * metres:.0f} mm"


def _on_paper(view: Camera, points: Array) -> Array:
    """(M, 2) mm from the picture's upper left corner."""
    seen = (points - view.centre) @ view.axes[:2].T * (SIZE[1] / view.height)
    return np.stack([0.5 * SIZE[0] + seen[:, 0], 0.5 * SIZE[1] - seen[:, 1]], axis=1)


def _dots(at: Array, texts: list[str], count: int) -> list[dict[str, Any]]:
    """Each place with its number beside it; numbers that would cover each other are pushed apart."""
    outwards = at - at[:count].mean(axis=0)
    label = at + BESIDE * outwards / np.maximum(np.linalg.norm(outwards, axis=1), 1e-6)[:, None]
    half = 0.5 * np.array(ROOM)
    for _ in range(STEPS):
        gap = label[:, None] - label[None]
        overlap = np.clip(2.0 * half - np.abs(gap), 0.0, None)
        overlap[np.arange(len(at)), np.arange(len(at))] = 0.0
        touching = (overlap > 0.0).all(axis=2)
        if not touching.any():
            break
        way = np.where(gap == 0.0, np.triu(np.ones(gap.shape[:2]), 1)[..., None] - 0.5, gap)
        push = np.where(touching[..., None], np.sign(way) * 0.25 * overlap, 0.0)
        label = np.clip(label + push.sum(axis=1), half, np.array(SIZE) - half)
    return [
        {"x": float(x), "y": float(y), "lx": float(lx), "ly": float(ly), "text": text, "mark": k >= count}
        for k, ((x, y), (lx, ly), text) in enumerate(zip(at, label, texts, strict=True))
    ]
