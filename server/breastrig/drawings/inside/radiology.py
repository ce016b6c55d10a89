"""A lesion's place as radiology writes it (side, hour, distance from the nipple), beside what was typed of a report.

The hour is that of the direction from the nipple on the face of the breast (`drawings/clock.py`), at any depth. Only
side and quadrant are compared: an hour differs by one between readers, and a distance by how the patient lies.
"""

import re
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES
from breastrig.drawings.clock import FittedSkin, circle_around, face_of
from breastrig.geometry.surface_points import SurfacePoints

FACE = 0.03  # m along the skin from the nipple: the circle whose plane is the face of the clock
BEHIND = 0.01  # m beside the nipple's axis: a lesion that is nearer lies behind the nipple and has no hour
APART, BEYOND = 1.5, 0.5  # hours that a written hour, and a written quadrant's edge, may be off
QUADRANTS = {
    "upper outer": 1.5,
    "lower outer": 4.5,
    "lower inner": 7.5,
    "upper inner": 10.5,
}  # middle hours, left breast
UNREAD = 'Not compared: write side and hour, for instance "left, 2 o\'clock, 45 mm".'

_HOUR = re.compile(
    r"\b(\d{1,2})(?:[:.](\d\d))?(?:\s*(?:-|–|to)\s*(\d{1,2}))?\s*(?:o\s*['’`]?\s*clock|uhr\b|heures?\b|horas?\b|h\b)"
)
_TIME = re.compile(r"\b(\d{1,2}):(\d\d)\b()")
_SIDES = {  # a letter before an apostrophe is an article
    "L": re.compile(r"\b(left|lt|links|linke[mnrs]?|gauche|izquierd[ao]|l)\b(?!['’])"),
    "R": re.compile(r"\b(right|rt|rechts|rechte[mnrs]?|droite?|derech[ao]|r)\b(?!['’])"),
}
_ACROSS = {"upper": "superior|upper|supero", "lower": "inferior|lower|infero"}
_ALONG = {"outer": "lateral|outer", "inner": "medial|inner"}


@dataclass(frozen=True)
class ClockPosition:
    """Where a lesion lies for a radiologist."""

    side: str  # L | R
    hour: float | None  # more than 0, up to 12; None behind the nipple
    distance: float  # m from the nipple, straight

    @property
    def text(self) -> str:
        """For instance: left, 2 o'clock, 45 mm from the nipple."""
        hour = "" if self.hour is None else f"{_spoken(self.hour)}, "
        return f"{SIDES[self.side]}, {hour}{1e3 * self.distance:.0f} mm {'from' if hour else 'behind'} the nipple"


@dataclass(frozen=True)
class RadiologyCheck:
    """What was typed of a report, beside where the lesion lies."""

    agrees: bool | None  # by side and quadrant; None where nothing of it can be compared
    text: str  # one sentence


def clock_position(skin: FittedSkin, nipple: SurfacePoints, side: str, center: Array) -> ClockPosition:
    """Of a place (3,) m inside; without an hour where the skin ends next to the nipple."""
    (from_nipple,) = center - skin.at(nipple)
    distance = float(np.linalg.norm(from_nipple))
    try:
        rim = skin.at(circle_around(skin, nipple, FACE))
    except BadDrawing:
        return ClockPosition(side, None, distance)
    three, twelve = (float(each @ from_nipple) for each in face_of(skin, rim - skin.at(nipple)))
    hour = float(np.arctan2(three, twelve)) * 6.0 / np.pi % 12.0 or 12.0
    return ClockPosition(side, hour if np.hypot(three, twelve) > BEHIND else None, distance)


def checked_radiology(written: str, place: ClockPosition, *, is_carried: bool) -> RadiologyCheck:
    """Compares typed words with a place; on another scan than that of the image by the side alone."""
    words = written.lower()
    sides = [side for side, pattern in _SIDES.items() if pattern.search(words)]
    side = sides[0] if len(sides) == 1 else None
    if side is not None and side != place.side:
        return RadiologyCheck(
            False, f"Radiology wrote {SIDES[side]}; this lesion lies in the {SIDES[place.side]} breast."
        )
    hour, within = _written_hour(words, place.side)
    if is_carried or hour is None or place.hour is None:
        return RadiologyCheck(True, "Same side as radiology wrote.") if side else RadiologyCheck(None, UNREAD)
    off = abs((place.hour - hour + 6.0) % 12.0 - 6.0)
    here, there = quadrant(place.side, place.hour), quadrant(place.side, hour)
    if here != there and off > within:
        wrote = there if within > APART else _spoken(hour)
        return RadiologyCheck(False, f"Radiology wrote {wrote}; this lesion lies at {_spoken(place.hour)} ({here}).")
    if side is None:
        return RadiologyCheck(
            None, "The same quadrant as radiology wrote, but no one side was read: write left or right."
        )
    return RadiologyCheck(True, "Agrees with radiology by side and quadrant.")


def quadrant(side: str, hour: float) -> str:
    """upper outer, lower outer, lower inner or upper inner."""
    left = hour % 12.0 if side == "L" else (12.0 - hour) % 12.0
    return list(QUADRANTS)[int(left // 3.0)]


def _written_hour(words: str, side: str) -> tuple[float | None, float]:
    """The hour that is written, or the middle of a quadrant, and by how much a place may be off."""
    found = _HOUR.search(words) or _TIME.search(words)
    if found:
        first, minutes, last = (int(each or 0) for each in found.groups())
        if not 1 <= first <= 12 or minutes > 59 or last > 12:
            return None, 0.0
        return (first + minutes / 60.0 + ((last - first) % 12) / 2.0 * bool(last)) % 12.0, APART
    for name, middle in QUADRANTS.items():
        across, along = name.split()
        short = rf"\b{across[0]}{along[0]}q\b"
        if re.search(rf"({_ACROSS[across]})\W*({_ALONG[along]})|{short}", words):
            return middle if side == "L" else 12.0 - middle, APART + BEYOND
    return None, 0.0


def _spoken(hour: float) -> str:
    """To the half hour: 2 o'clock, 2:30."""
    halves = round(2.0 * hour)
    whole = halves // 2 % 12 or 12
    return f"{whole}:30" if halves % 2 else f"{whole} o'clock"
