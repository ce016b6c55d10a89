"""Bands of measures: what the radii of their ends leave open, as the half width that holds nine of ten true lengths.

An end's radius holds its true place with 90 % in all directions; along one of them three quarters of it would do where
the place is the model's.  A picked landmark is measured from where it was picked, which the radius does not know of: a
whole one then.  Two ends are wrong independently.  Ratios move less, for both sides' ends are wrong alike.

Tried on whole scans of warped bodies (evaluate --warped: studies/measures.py), exact picks, picks 5 mm off and none.
"""

from collections.abc import Sequence

import numpy as np

from breastrig.report.table import Value

KNOWN_MM = 60.0  # a larger radius is that of a breast or more: nothing is known of the place
OF_LENGTH = 1.0  # of the radii; 0.72 held 65 to 85 % of lengths between picks 5 mm off
OF_RATIO = 0.72  # held 92 % and more, but for picks 5 mm off (77 to 100 %)


def margin_text(mm: float | None) -> str:
    """± 6 mm, of a radius in mm that holds nine of ten places."""
    return "not known" if mm is None or mm > KNOWN_MM else f"± {mm:.0f} mm"


def margins_text(radii: Sequence[float | None]) -> str:
    """± 2 to 4 mm, of several; those that are not known are counted."""
    known = sorted(round(mm) for mm in radii if mm is not None and mm <= KNOWN_MM)
    if not known:
        return "not known"
    most = "" if known[0] == known[-1] else f" to {known[-1]}"
    unknown = f", {len(radii) - len(known)} not known" if len(known) < len(radii) else ""
    return f"± {known[0]}{most} mm{unknown}"


def sure_text(lines_mm: float | None, landmarks_mm: Sequence[float]) -> str:
    """What a fit is good for: lines on the breasts ± 6 mm, landmarks ± 2 to 4 mm; empty where nothing is known."""
    said = [] if lines_mm is None else [f"lines on the breasts {margin_text(lines_mm)}"]
    return ", ".join([*said, f"landmarks {margins_text(landmarks_mm)}"] if landmarks_mm else said)


def half_width(radii: Sequence[float | None], share: float = OF_LENGTH) -> float | None:
    """In the radii's unit; None where one is not known."""
    known = [radius for radius in radii if radius is not None]
    return share * float(np.linalg.norm(known)) if len(known) == len(radii) and known else None


def banded(value: float, half: float | None, least: float = 0.0, most: float = np.inf) -> Value:
    """The value with its band, which cannot leave what is possible."""
    return Value(value) if half is None else Value(value, max(value - half, least), min(value + half, most))


def ratio_half_width(pair: Sequence[float], halves: Sequence[float | None]) -> float | None:
    """Of the smaller over the larger of two lengths of these half widths."""
    known = [half for half in halves if half is not None]
    if len(known) < len(halves) or min(np.abs(pair)) <= 0.0:
        return None
    low, high = sorted(np.abs(pair))
    return float(low / high * np.linalg.norm(np.array(known) / np.abs(pair)))
