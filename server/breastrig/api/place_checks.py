"""Checks landmarks and lines of requests: known names, and points that can be meant for this scan."""

from collections.abc import Sequence

import numpy as np

from breastrig.api.served_model import ServedModel
from breastrig.api.wire import common as wire
from breastrig.core.errors import BadDrawing, BadLandmarks, unknown_names
from breastrig.core.picks import Picks, Points
from breastrig.core.units import METRES_PER_UNIT, distance_text
from breastrig.scan.landmarks.landmark_files import REACH, checked_certain, landmark_file, landmarks_of_file
from breastrig.scan.landmarks.marks import check_mark_names, with_marks
from breastrig.storage.documents.scans import StoredScan

REACH_M = 0.05  # beyond the scan's bounds: over a hole at the rim, under a hand that drags; further out is another scan


def picks_of_file(data: bytes, scan: StoredScan, model: ServedModel) -> Picks:
    """The landmarks of a file on this scan, under the model's names. Raises BadLandmarks."""
    bounds = scan.facts["bounds_m"]
    measured = METRES_PER_UNIT[scan.facts["unit"]], (np.array(bounds["min"]), np.array(bounds["max"]))
    found = landmarks_of_file(data, lambda: measured, scale=scale_of(scan))
    picks = with_marks(found, _words(model))
    check_landmarks(picks, scan, model)
    return picks


def _words(model: ServedModel) -> dict[str, tuple[str, str]]:
    return {each.name: (each.label, each.latin) for each in model.rig.landmarks}


def given_picks(given: wire.GivenLandmarkFile, stored: Picks, scan: StoredScan) -> Picks:
    """The landmarks of a request in the scan's present size, and its marks, else those that are stored."""
    mm, present = 1e3 * METRES_PER_UNIT[given.unit], scale_of(scan)
    places, marks = _scaled(given, mm * present / (given.scale or present))
    return Picks(places, tuple(given.certain), given.confidence, stored.marks_mm if given.marks is None else marks)


def landmark_answer(picks: Picks, scan: StoredScan) -> wire.LandmarkFile:
    return wire.LandmarkFile(
        landmarks=picks.points_mm,
        marks=picks.marks_mm,
        certain=list(picks.certain),
        confidence=picks.confidence,
        scale=scale_of(scan),
    )


def scale_of(scan: StoredScan) -> float:
    """The scan's size, times that of its file."""
    factor: float = scan.facts.get("scale", {}).get("factor", 1.0)
    return factor


def written_file(given: wire.GivenLandmarkFile, kind: str, scan: StoredScan) -> bytes:
    """The landmarks of a request as a file: json in mm, other kinds in the scan's unit. Raises BadLandmarks."""
    unit = scan.facts["unit"]
    factor = METRES_PER_UNIT[given.unit] / (1e-3 if kind == "json" else METRES_PER_UNIT[unit])
    places, marks = (
        {name: np.array([float(f"{value:.8g}") for value in at]) for name, at in each.items()}
        for each in _scaled(given, factor)
    )
    known = given.certain, given.confidence
    return landmark_file(places, kind, "mm" if kind == "json" else None, *known, marks, given.scale or scale_of(scan))


def _scaled(given: wire.GivenLandmarkFile, factor: float) -> tuple[Points, Points]:
    """Landmarks and marks, each coordinate times the factor."""
    places, marks = (
        {name: [factor * value for value in place] for name, place in each.items()}
        for each in (given.landmarks, given.marks or {})
    )
    return places, marks


def check_landmarks(picks: Picks, scan: StoredScan, model: ServedModel) -> None:
    """Raises BadLandmarks with a sentence."""
    checked_certain(picks.certain, picks.points_mm, picks.confidence)
    for name in picks.confidence:
        if name not in picks.points_mm:
            raise BadLandmarks(f'"confidence" names {name}, which is not among these landmarks; take it out.')
    names = model.rig.landmark_names
    if unknown := [name for name in picks.points_mm if name not in names]:
        raise BadLandmarks(unknown_names("landmark", unknown, names))
    check_mark_names(picks.marks_mm, _words(model))
    for name, point in (picks.points_mm | picks.marks_mm).items():
        if (outside := _metres_outside(point, scan)) > REACH:
            raise BadLandmarks(f"{name} lies {_outside('landmarks', outside, scan)}")


def check_near_scan(name: str, points: Sequence[Sequence[float]], scan: StoredScan) -> None:
    """Raises BadDrawing with a sentence when one of the points (mm, scan frame) lies far outside.

    It costs nothing; how far a line is off the skin is measured where the scan is read (service/scans/skin_checks.py).
    """
    for point in points:
        if (outside := _metres_outside(point, scan)) > REACH_M:
            raise BadDrawing(f'A point of "{name}" lies {_outside("drawings", outside, scan)}')


def _metres_outside(point: Sequence[float], scan: StoredScan) -> float:
    """m from the scan's bounds to a point (mm, scan frame), along the worst axis; below zero inside."""
    low, high = scan.facts["bounds_m"]["min"], scan.facts["bounds_m"]["max"]
    return float(max(max(a - x / 1000, x / 1000 - b) for x, a, b in zip(point, low, high, strict=True)))


def _outside(what: str, metres: float, scan: StoredScan) -> str:
    """In metres, as what is of another unit is off by metres; in words where that would be digits."""
    shown = f"{metres:.2f} m" if metres < 10.0 else distance_text(metres)
    return (
        f"{shown} outside of the scan; {what} are millimetres in the scan's own frame, and this scan was read in "
        f"{scan.facts['unit']}."
    )
