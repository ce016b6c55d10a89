"""The nipple within its areola: near the middle, a spot of other colour, and a bump.

Each says where it may be on a grid over the areola: the middle as a Gaussian, colour and height as how much a small
disc differs from what is around it, in units of how much it does so elsewhere on the same areola.  Their product is the
observation: its mean is the place, its second moments are the error; where neither spot nor bump is seen the middle is
left with the error that it has.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from breastrig.colour.features.areola import Areola, candidates, level_colour, measured
from breastrig.colour.features.limits import AreolaLimits
from breastrig.colour.features.observation import Observation
from breastrig.colour.features.patch import ColouredSkin, Patch
from breastrig.core.arrays import Array, Booleans

SEARCH_PIXEL = 0.0015  # m
SEARCH_HALF = 0.075  # m, half the side of the picture in which an areola is searched
PIXEL = 0.001  # m
AROUND = 1.3  # radii of a spot or bump: the Gaussian of what is around it
MOST = 5.0  # standard deviations; more says no more
AREOLA_SEEN = "areola seen"


def find_nipple(
    skin: ColouredSkin, expected: Array, outwards: Array, up: Array, spread: float, limits: AreolaLimits
) -> Observation | None:
    """The nipple near the `expected` place (3,) m, whose usual error is `spread` m; None where no areola can be seen.

    `outwards` and `up` (3,) are unit directions of the body there.
    """
    normal = skin.normal(expected, outwards, 0.03)
    patch = skin.patch(expected, normal, up, SEARCH_HALF, SEARCH_PIXEL)
    for candidate in candidates(patch, limits, spread):
        place = patch.place(candidate.right, candidate.up)
        areola = None if place is None else measured(skin, place, normal, up, candidate.radius, limits.radius_floor)
        if areola is None or not is_areola(areola, limits):
            continue
        if np.linalg.norm(areola.centre - expected) > limits.farthest * spread:
            continue
        return _within(skin, areola, up, limits)
    return None


def is_areola(areola: Areola, limits: AreolaLimits) -> bool:
    """Whether a measured patch is an areola, by size, colour, border and form."""
    redness = float(areola.contrast[1])
    sure = areola.clearness > limits.sure_clearness and areola.border > limits.sure_border
    return bool(
        limits.smallest < areola.radius < limits.largest
        and float(np.linalg.norm(areola.contrast)) > limits.least_contrast
        and (redness > limits.least_redness or (sure and redness > limits.sure_redness))
        and areola.clearness > limits.least_clearness
        and areola.roundness < limits.most_scatter
        and areola.border > limits.least_border
    )


def _within(skin: ColouredSkin, areola: Areola, up: Array, limits: AreolaLimits) -> Observation:
    patch = skin.patch(areola.centre, areola.normal, up, areola.radius + 0.010, PIXEL)
    level, known = level_colour(patch)
    right, high = patch.offsets()
    away = np.hypot(right, high)
    inside = known & (away < 0.75 * areola.radius)
    if inside.sum() < 30:
        return _at_the_middle(areola, limits)
    colour = limits.lightness * -level[..., 0] + limits.redness * level[..., 1]
    spot, bump = (
        np.minimum(standing_out(value, known, inside, limits.spot / patch.pixel, AROUND), MOST)
        for value in (colour, height_above(patch))
    )
    evidence = limits.spot_weight * spot + limits.bump_weight * bump
    evidence -= 0.5 * (away / limits.off_centre) ** 2
    chance = np.where(inside, np.exp(evidence - evidence[inside].max()), 0.0)
    chance /= chance.sum()
    mean = np.array([(chance * right).sum(), (chance * high).sum()])
    place = patch.place(float(mean[0]), float(mean[1]))
    if place is None:
        return _at_the_middle(areola, limits)
    off = np.stack([right - mean[0], high - mean[1]], axis=-1)
    flat = np.einsum("rc,rci,rcj->ij", chance, off, off)
    axes = patch.axes[:2]
    covariance = limits.error_scale**2 * (axes.T @ flat @ axes) + areola.covariance + limits.floor**2 * np.eye(3)
    return Observation(place, covariance, AREOLA_SEEN, areola)


def _at_the_middle(areola: Areola, limits: AreolaLimits) -> Observation:
    flat = np.eye(3) - np.outer(areola.normal, areola.normal)
    error = limits.off_centre**2 * flat + limits.floor**2 * np.eye(3)
    return Observation(areola.centre, areola.covariance + error, AREOLA_SEEN, areola)


def standing_out(value: Array, known: Booleans, inside: Booleans, radius: float, around: float) -> Array:
    """(N, N) how much a spot of this radius (pixels) exceeds what is `around` (radii), in its scatter inside; >= 0."""
    filled = np.where(known, value, np.median(value[inside]))
    difference = gaussian_filter(filled, 0.6 * radius) - gaussian_filter(filled, around * radius)
    scatter = 1.4826 * float(np.median(np.abs(difference[inside] - np.median(difference[inside]))))
    return np.asarray(np.maximum(difference / max(scatter, 1e-9), 0.0))


def height_above(patch: Patch) -> Array:
    """(N, N) m over the smooth form of the breast there (a paraboloid)."""
    middle = patch.places[len(patch.places) // 2, len(patch.places) // 2]
    origin = middle if np.isfinite(middle).all() else np.nanmean(patch.places, axis=(0, 1))
    height = (patch.places - origin) @ patch.axes[2]
    right, high = patch.offsets()
    rows = np.stack([np.ones_like(right), right, high, right**2, right * high, high**2], axis=-1)
    known = np.isfinite(height)
    form, *_ = np.linalg.lstsq(rows[known], height[known], rcond=None)
    return np.where(known, height - rows @ form, 0.0)
