"""Line errors: the 90 % radius of each point of a line, and one number across the line.

A projected line has the error of the model under it. A line that is transferred between scans has the errors of both
fits there, whatever it had before; but the part that both fits share (one model, one body) cancels, so the root sum of
squares of both radii is reduced by a factor, and an error of the skin itself is added. Both are estimated on bodies
with known skin (skin_maps). A prediction shares nothing with the truth, so its radii count in full.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import Polyline, parts
from breastrig.rig.model import Rig

ACROSS = 0.71  # of a place's radius: across a line through it (docs/decisions/0018)

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


def radii_at(rig: Rig, fitted: ClosestPointSearch, radii: Array, points: Array) -> Array:
    """(M,) m: the (V,) m radii of the fitted model's vertices, at (M, 3) m points near it."""
    nearest = fitted.query(points)
    return np.asarray(np.einsum("mc,mc->m", nearest.barycentric, radii[rig.faces[nearest.faces]]))


def carried_errors(
    rig: Rig, a: FittedScan, b: FittedScan, on_a: Array, on_b: Array, *, on_skin: bool = True
) -> Array | None:
    """(M,) m: errors of (M, 3) m points of A's skin that were transferred to (M, 3) m on B; None when unknown.

    Skin that hangs in one of two scans slides farther over the tissue below it; a prediction's radii include that.
    """
    settings = skin_map_settings(rig)
    if settings.error_skin is None or settings.error_share is None:
        return None
    is_hung = on_skin and not (a.predicted or b.predicted) and (a.stance == PRONE) != (b.stance == PRONE)
    total = np.full(len(on_a), settings.error_skin**2 + (settings.error_hanging**2 if is_hung else 0.0))
    for scan, points in ((a, on_a), (b, on_b)):
        if scan.radii is None:
            return None
        share = 1.0 if scan.predicted else settings.error_share
        total += (share * radii_at(rig, scan.search(rig), scan.radii, points)) ** 2
    return np.asarray(np.sqrt(total))


def with_errors(
    rig: Rig, fitted: ClosestPointSearch, radii: Array | None, lines: Sequence[Polyline]
) -> tuple[Polyline, ...]:
    """The lines on the scan of a fitted model, each point with its radius; unchanged where none are known."""
    if radii is None or not lines:
        return tuple(lines)
    errors = radii_at(rig, fitted, radii, np.concatenate([line.points for line in lines]))
    return tuple(replace(line, error=errors[part]) for line, part in zip(lines, parts(lines), strict=True))
