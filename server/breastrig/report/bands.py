"""Bands of measures: what the radii of their ends leave open, as the half width that holds nine of ten true lengths.

An end's radius holds its true place with 90 % in all directions; along one of them three quarters of it would do where
the place is the model's.  A picked landmark is measured from where it was picked, which the radius does not know of: a
whole one then.  Picks are wrong independently; places of the
model share most of what they are wrong by, so that their covariance says what a length, or a difference of two, leaves
open.  What points that are no landmarks are off by, and share, was measured (calibration.py).

Tried on whole scans of warped bodies (evaluate --warped: studies/measures.py), exact picks, picks 5 mm off and none.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import split_side
from breastrig.files.result import ResultFile
from breastrig.report.body_frame import BodyFrame
from breastrig.report.stance import MODEL, Place
from breastrig.report.table import KNOWN_MM as KNOWN_MM
from breastrig.report.table import Row, Value, says_nothing

Joint = tuple[tuple[str, ...], Array]  # landmarks and the (3 L, 3 L) m² of the model's errors there

OTHER = {"L": "R", "R": "L"}
OF_90 = 1.645  # standard deviations to either side that hold nine of ten numbers
OF_LENGTH = 1.0  # of the radii; 0.72 held 65 to 85 % of lengths between picks 5 mm off
OF_RATIO = 0.72  # held 92 % and more, but for picks 5 mm off (77 to 100 %)


def whole_mm(radius: float) -> int:
    """A radius in whole mm; halves go up, as on the page: paper and screen say the same."""
    return math.floor(radius + 0.5)


def margin_text(mm: float | None) -> str:
    """± 6 mm, for a 90 % radius in mm."""
    return "not known" if mm is None or mm > KNOWN_MM else f"± {whole_mm(mm)} mm"


def margins_text(radii: Sequence[float | None]) -> str:
    """± 2 to 4 mm, for several; unknown ones are counted."""
    known = sorted(whole_mm(mm) for mm in radii if mm is not None and mm <= KNOWN_MM)
    if not known:
        return "not known"
    most = "" if known[0] == known[-1] else f" to {known[-1]}"
    unknown = f", {len(radii) - len(known)} not known" if len(known) < len(radii) else ""
    return f"± {known[0]}{most} mm{unknown}"


def lines_text(lines_mm: float | None, drawn_mm: float | None) -> str:
    """Line error (90 %): drawn lines ± 6 mm, or lines on the breasts where none is drawn; empty where it is unknown.

    Both are line errors (drawings/line_error.py), in mm, of the line or the breast with the larger one.
    """
    what, mm = ("lines on the breasts", lines_mm) if drawn_mm is None else ("drawn lines", drawn_mm)
    return "" if mm is None else f"{what} {margin_text(mm)}"


def sure_text(result: ResultFile, drawn_mm: float | None) -> str:
    """Errors (90 %) of a fit: drawn lines ± 6 mm, landmarks ± 2 to 4 mm; empty where they are unknown."""
    landmarks = list(result.landmark_uncertainty_mm.values())
    said = [lines_text(result.line_error_mm, drawn_mm), f"landmarks {margins_text(landmarks)}" if landmarks else ""]
    return ", ".join(filter(None, said))


def half_width(radii: Sequence[float | None]) -> float | None:
    """Half of the 90 % band of a length from its ends' radii, in their unit; None where one is not known."""
    known = [radius for radius in radii if radius is not None]
    return float(np.linalg.norm(known)) if len(known) == len(radii) and known else None


def shared_half_width(
    ends: Sequence[tuple[Place, Array]], joint: Joint | None, share: float = OF_LENGTH
) -> float | None:
    """m, of a number that changes by the (3,) direction with each place, of which one may stand several times.

    None where a radius is not known.  Without `joint` places of the model count as picked ones do, by a share of their
    radii.
    """
    moved: dict[str, tuple[Place, Array]] = {}
    for place, way in ends:
        moved[place.name] = (place, way + (moved[place.name][1] if place.name in moved else 0.0))
    names: tuple[str, ...] = () if joint is None else joint[0]
    alone, together = [0.0], np.zeros(3 * len(names))
    for place, way in moved.values():
        if place.radius is None:
            return None
        if place.source == MODEL and place.name in names:
            first = 3 * names.index(place.name)
            together[first : first + 3] = way
        else:
            alone.append(share * place.radius * float(np.linalg.norm(way)))
    variance = 0.0 if joint is None else float(together @ joint[1] @ together)
    return float(np.hypot(np.linalg.norm(alone), OF_90 * np.sqrt(max(variance, 0.0))))


@dataclass(frozen=True)
class Points:
    """Errors (m, 90 %, along the length) of one point of each of two lengths, and the errors' correlation."""

    halves: tuple[float | None, float | None] = (0.0, 0.0)
    correlation: float = 0.0

    def together(self, shares: Sequence[float]) -> float | None:
        """Half of the band of a number that changes by these shares with the two; None where one is unknown."""
        left, right = (None if half is None else share * half for half, share in zip(self.halves, shares, strict=True))
        if left is None or right is None:
            return None
        return float(np.sqrt(max(left * left + right * right + 2.0 * self.correlation * left * right, 0.0)))


def between_sides(joint: Joint, frame: BodyFrame, apart: float) -> Joint:
    """The joint covariance for differences of left and right: both sides' errors are more alike than a fit knows.

    Errors have a part that mirrors itself in the median plane, and one that does the opposite and makes differences.
    Of this one a share `apart` counts; the other grows, so that the variance of one landmark alone stays the same where
    both parts are equal.
    """
    names, covariance = joint
    mirrored = np.eye(3) - 2.0 * np.outer(frame.axes[:, 0], frame.axes[:, 0])
    alike = float(np.sqrt(2.0 - apart * apart))
    turned = np.eye(3 * len(names))
    blocks = turned.reshape(len(names), 3, len(names), 3)
    for k, name in enumerate(names):
        stem, side = split_side(name)
        partner = f"{stem}_{OTHER[side]}" if side else name
        if partner in names:
            blocks[k, :, k] *= 0.5 * (alike + apart)
            blocks[k, :, names.index(partner)] += 0.5 * (alike - apart) * mirrored
    return names, np.asarray(turned @ covariance @ turned.T)


def half_between(left: Value | None, right: Value | None, correlation: float) -> float | None:
    """Half of the band of the difference of two numbers with this correlation of errors; None where one is unknown."""
    halves = (None if left is None else left.margin, None if right is None else right.margin)
    return Points(halves, correlation).together((1.0, -1.0))


def banded(value: float, half: float | None, least: float = 0.0, most: float = np.inf) -> Value:
    """The value with its band, cut at the possible range."""
    return Value(value) if half is None else Value(value, max(value - half, least), min(value + half, most))


def without_unknown(row: Row) -> Row:
    """The rows without numbers whose bands are too wide to mean anything."""
    if row.unit == "grade":
        return row
    cells = {name: value for name in ("left", "right", "value") if (value := getattr(row, name)) is not None}
    gone = [name for name, value in cells.items() if _says_nothing(row, value)]
    kept = row.with_values(lambda value: value if not _says_nothing(row, value) else None)
    if says_nothing(kept.difference, row, list(cells.values())) or {"left", "right"} & {*gone}:
        gone.append("difference")
    return replace(kept, not_known=tuple(gone)) if gone else row


def _says_nothing(row: Row, value: Value) -> bool:
    """Whether the band is too wide: it includes zero, all possible ratios, or heights beyond KNOWN_MM."""
    if value.margin is None:
        return False
    if row.unit == "1":
        return value.low == 0.0 and value.high == 1.0
    return value.margin > KNOWN_MM if row.kind == "in height" else value.value - value.margin <= 0.0


def ratio_half_width(
    pair: Sequence[float],
    ends: Sequence[Sequence[tuple[Place, Array]]],
    points: Points,
    joint: Joint | None,
    part: float = OF_RATIO,
) -> float | None:
    """Half of the 90 % band of the smaller over the larger of two lengths, to first order; shared errors cancel.

    `ends` are, for each length, the places with the (3,) direction in which it grows, of whose radii `part` counts;
    `points` say by how much a point of each length that is no landmark is off.
    """
    if min(np.abs(pair)) <= 0.0:
        return None
    ratio = min(np.abs(pair)) / max(np.abs(pair))
    shares = ratio / pair[0], -ratio / pair[1]
    ways = [(place, share * way) for share, side in zip(shares, ends, strict=True) for place, way in side]
    return half_width([shared_half_width(ways, joint, part), points.together(shares)])


def ways_to_midline(place: Place, frame: BodyFrame, known: Mapping[str, Place]) -> list[tuple[Place, Array]]:
    """Gradients (3,) of a place's distance to the median plane by the place and by the landmarks of the plane.

    The plane is the model's: it moves with the model's landmarks on it.
    """
    out = outwards(place, frame)
    middle = [replace(each, source=MODEL) for name, each in known.items() if name == split_side(name)[0]]
    return [(place, out), *((each, -out / len(middle)) for each in middle if each.name != place.name)]


def outwards(place: Place, frame: BodyFrame) -> Array:
    """(3,) away from the median plane."""
    return np.asarray(np.copysign(1.0, frame.lateral(place.point)) * frame.axes[:, 0])
