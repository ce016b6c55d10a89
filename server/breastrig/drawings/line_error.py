"""Line errors: the 90 % radius of each point of a line, and one number across the line.

A projected line has the error of the model under it, a transferred one that of both scans (skin_maps/scan_errors.py).
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.skin_maps.marks import left_over
from breastrig.drawings.skin_maps.scan_errors import radii_at, squared_errors
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import Polyline, parts
from breastrig.rig.model import Rig

ACROSS = 0.71  # of a place's radius: across a line through it (docs/decisions/0018)

HOLDS_90 = 2.15  # 90 % radius of a place that is off by one standard deviation on each of the skin's two axes
FINGER = 0.01  # m, of a line error: a finger's breadth is 20 mm, half of it on each side
MOST_FINGERS = 3  # "or more": beyond two nobody plans by the difference


def fingers(line_error: float) -> int:
    """The breadth of the band around a line with this error (m) in fingers: 1, 2, or 3 for all that is broader."""
    return min(max(int(np.ceil(line_error / FINGER)), 1), MOST_FINGERS)


def across(radii: Array) -> float:
    """Line error (90 %), measured across a line, from the radii of its points or of a fit's breasts, in their unit."""
    return ACROSS * float(np.sqrt(np.mean(np.square(radii))))


def drawn_error(lines: Iterable[Polyline]) -> float | None:
    """The largest line error (90 %) of the lines, in m; None where none is known.

    This is the number of an item, which has one or several lines, and of everything that is drawn on a scan.
    """
    radii = [line.error[np.isfinite(line.error)] for line in lines if line.error is not None]
    return max((across(known) for known in radii if len(known)), default=None)


def carried_errors(
    rig: Rig,
    a: FittedScan,
    b: FittedScan,
    on_a: Array,
    on_b: Array,
    *,
    on_skin: bool = True,
    marks: Sequence[str] = (),
) -> Array | None:
    """(M,) m: errors of (M, 3) m points of A's skin that were transferred to (M, 3) m on B; None when unknown.

    `marks` names those of both scans that the transfer followed: the nearer, the less is left of the error.
    """
    left: Array | float = 1.0
    if marks:
        here, there = (np.array([scan.marks[name] for name in marks]) for scan in (a, b))
        at_marks = squared_errors(rig, a, b, here, there)
        if at_marks is not None:
            left = left_over(on_a, here, np.sqrt(at_marks) / HOLDS_90, skin_map_settings(rig))
    total = squared_errors(rig, a, b, on_a, on_b, on_skin=on_skin, left=left)
    return None if total is None else np.asarray(np.sqrt(total))


def with_errors(
    rig: Rig, fitted: ClosestPointSearch, radii: Array | None, lines: Sequence[Polyline]
) -> tuple[Polyline, ...]:
    """The lines on the scan of a fitted model, each point with its radius; unchanged where none are known."""
    if radii is None or not lines:
        return tuple(lines)
    errors = radii_at(rig, fitted, radii, np.concatenate([line.points for line in lines]))
    return tuple(replace(line, error=errors[part]) for line, part in zip(lines, parts(lines), strict=True))
