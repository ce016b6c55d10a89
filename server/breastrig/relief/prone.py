"""Nipples, folds and xiphoid of a prone body from the depth of its skin along the front axis (docs/decisions/0019).

Hanging breasts are the two foremost places of the skin, one on each side; a nipple is the place near its breast's apex
that stands out most from the skin around.  A fold is where the skin below is most concave along the body; the xiphoid
lies between the folds.  Errors are those on synthetic bodies (breastrig_studies/virtual/warped/prone.py).
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.stances import OUTWARDS
from breastrig.geometry.rays import RayCaster

STEP = 0.003  # m, of the depth's grid
SMOOTH, FINE, COARSE = 0.006, 0.003, 0.010  # m, Gaussians: of the skin, and of what a nipple stands out from
BESIDE = 0.02  # m from the middle, where a breast's apex lies at least
NEAR_APEX, STEEP = 0.022, 0.8  # m, where a nipple is looked for, and the slope on which none is
PER_SQUARE = 2.0  # 1/m, by which standing out counts less away from the apex
BELOW, WIDE = 0.02, 0.024  # m under the nipple, and to its sides: where a fold is looked for
NIPPLE_DOWN, FOLD_UP, XIPHOID_DOWN = 0.003, 0.004, 0.009  # m from what is seen to where the landmarks are
ERRORS = {  # m outwards, up, front, of these places
    "nipple": (0.005, 0.005, 0.003),
    "inframammary_fold": (0.015, 0.005, 0.010),
    "xiphoid": (0.006, 0.008, 0.003),
}
REASON = "form of the hanging breasts"
LEAST = 400  # places of the grid with skin; fewer are no front


def seen_from(vertices: Array, faces: Integers, axes: Array) -> dict[str, Array] | None:
    """(3,) m by landmark, for (3, 3) axes of the body (columns left, up, front); None: no front with two breasts."""
    local = vertices @ axes
    low, high = local.min(axis=0), local.max(axis=0)
    x, y = (np.arange(low[k], high[k], STEP) for k in (0, 1))
    if len(x) < 8 or len(y) < 8 or len(x) * len(y) > 1_000_000:
        return None
    depth = _depth(local, faces, x, y, float(high[2]))
    skin = np.isfinite(depth)
    if skin.sum() < LEAST:
        return None
    smooth = _smoothed(depth, SMOOTH)
    fine = _smoothed(depth, FINE) - _smoothed(depth, COARSE)
    slopes = np.gradient(smooth, STEP)
    level = np.hypot(*slopes) < STEEP
    bent = np.gradient(slopes[0], STEP, axis=0) / (1.0 + slopes[0] ** 2) ** 1.5
    middle = float(x[np.nonzero(skin)[1]].mean())
    places = {}
    for side, outwards in OUTWARDS.items():
        apex = _highest(np.where((x - middle) * outwards > BESIDE, smooth, np.nan))
        if apex is None:
            return None
        away = (x - x[apex[1]]) ** 2 + (y - y[apex[0]])[:, None] ** 2
        nipple = _highest(np.where((away < NEAR_APEX**2) & level, fine - PER_SQUARE * away, np.nan)) or apex
        below = np.where((y < y[nipple[0]] - BELOW)[:, None] & (np.abs(x - x[apex[1]]) < WIDE), bent, np.nan)
        counts = np.isfinite(below).sum(axis=1)
        rows = np.where(counts > 0, np.nansum(below, axis=1) / np.maximum(counts, 1), -np.inf)
        fold = (int(rows.argmax()), apex[1])
        places[f"nipple_{side}"] = np.array([x[nipple[1]], y[nipple[0]] - NIPPLE_DOWN, depth[nipple]])
        if np.isfinite(rows.max()) and np.isfinite(smooth[fold]):
            places[f"inframammary_fold_{side}"] = np.array([x[fold[1]], y[fold[0]] + FOLD_UP, smooth[fold]])
    folds = [place for name, place in places.items() if name.startswith("inframammary")]
    if len(folds) == len(OUTWARDS):
        at_x = 0.5 * (places["nipple_L"][0] + places["nipple_R"][0])
        at_y = 0.5 * (folds[0][1] + folds[1][1]) - FOLD_UP - XIPHOID_DOWN
        at_z = smooth[np.abs(y - at_y).argmin(), np.abs(x - at_x).argmin()]
        if np.isfinite(at_z):
            places["xiphoid"] = np.array([at_x, at_y, at_z])
    return {name: axes @ place for name, place in places.items()}


def _depth(local: Array, faces: Integers, x: Array, y: Array, high: float) -> Array:
    """(Y, X) m along the front, nan where there is no skin."""
    starts = np.stack([*(each.ravel() for each in np.meshgrid(x, y)), np.full(len(x) * len(y), high + STEP)], axis=1)
    hits = RayCaster(local, faces).hits(starts, np.broadcast_to([0.0, 0.0, -1.0], starts.shape))
    return np.where(hits.faces >= 0, starts[:, 2] - hits.distances, np.nan).reshape(len(y), len(x))


def _smoothed(depth: Array, size: float) -> Array:
    """Gaussian of this standard deviation (m) over the skin that there is."""
    from scipy.ndimage import gaussian_filter  # slow to load, and few scans are prone

    there: Booleans = np.isfinite(depth)
    share = gaussian_filter(there.astype(np.float64), size / STEP)
    mean = gaussian_filter(np.where(there, depth, 0.0), size / STEP) / np.maximum(share, 1e-6)
    return np.where(there, mean, np.nan)


def _highest(values: Array) -> tuple[int, int] | None:
    """Row and column of the largest value; None where all are nan."""
    if not np.isfinite(values).any():
        return None
    row, column = np.unravel_index(int(np.nanargmax(values)), values.shape)
    return int(row), int(column)
