"""How far off places are that were carried between two scans, by the radii of both fits there.

What a line had before does not count.  The part that both fits share (one model, one body) cancels, so the root sum of
squares of both radii is reduced by a factor, and an error of the skin itself is added.  Both are estimated on bodies
with known skin.  A prediction shares nothing with the truth, so its radii count in full.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.rig.model import Rig


def radii_at(rig: Rig, fitted: ClosestPointSearch, radii: Array, points: Array) -> Array:
    """(M,) m: the (V,) m radii of the fitted model's vertices, at (M, 3) m points near it."""
    nearest = fitted.query(points)
    return np.asarray(np.einsum("mc,mc->m", nearest.barycentric, radii[rig.faces[nearest.faces]]))


def squared_errors(
    rig: Rig,
    a: FittedScan,
    b: FittedScan,
    on_a: Array,
    on_b: Array,
    *,
    on_skin: bool = True,
    left: Array | float = 1.0,
) -> Array | None:
    """(M,) m²: squares of the 90 % radii of (M, 3) m points of A's skin carried to (M, 3) m on B; None when unknown.

    `left` (M,) is the share of the map's variance that marks leave; it reduces nothing of a prediction.  Skin that
    hangs in one of two scans slides farther over the tissue below it; a prediction's radii include that.
    """
    settings = skin_map_settings(rig)
    if settings.error_skin is None or settings.error_share is None:
        return None
    is_hung = on_skin and not (a.predicted or b.predicted) and (a.stance == PRONE) != (b.stance == PRONE)
    total = np.full(len(on_a), settings.error_skin**2 + (settings.error_hanging**2 if is_hung else 0.0)) * left
    for scan, points in ((a, on_a), (b, on_b)):
        if scan.radii is None:
            return None
        share, stays = (1.0, 1.0) if scan.predicted else (settings.error_share, left)
        total += (share * radii_at(rig, scan.search(rig), scan.radii, points)) ** 2 * stays
    return total
