"""The navel: a spot of darker or redder skin and a dent, one above the other, on the body's midline.

The form gives the midline well and the height hardly: bellies have no shape that shows the navel's height. So the
picture is narrow and high, and both signs are searched in it, each in units of its scatter on the rest of the belly. It
is taken only where they leave one place.
"""

import numpy as np

from breastrig.colour.features.areola import level_colour
from breastrig.colour.features.limits import NavelLimits
from breastrig.colour.features.nipple import height_above, standing_out
from breastrig.colour.features.observation import Observation
from breastrig.colour.features.patch import ColouredSkin
from breastrig.core.arrays import Array

PIXEL = 0.0015  # m
HALF = 0.085  # m, half the side of the picture
AROUND = 1.6  # radii of a spot or dent: the Gaussian of what is around it
NAVEL_SEEN = "navel seen"


def find_navel(
    skin: ColouredSkin, expected: Array, outwards: Array, up: Array, spread: float, limits: NavelLimits
) -> Observation | None:
    """The navel near the `expected` place (3,) m, whose usual error is `spread` m; None where none stands out."""
    patch = skin.patch(expected, skin.normal(expected, outwards, 0.03), up, HALF, PIXEL)
    level, known = level_colour(patch)
    right, high = patch.offsets()
    inside = known & (np.abs(right) < 3.0 * limits.aside)
    if inside.sum() < 0.3 * inside.size * 3.0 * limits.aside / HALF:
        return None
    colour = limits.lightness * -level[..., 0] + limits.redness * level[..., 1]
    spot = standing_out(colour, known, inside, limits.spot / patch.pixel, AROUND)
    dent = standing_out(-height_above(patch), known, inside, limits.dent / patch.pixel, AROUND)
    evidence = limits.weight * (np.minimum(spot, limits.most) + np.minimum(dent, limits.most))
    evidence = evidence - 0.5 * ((right / limits.aside) ** 2 + (high / max(spread, limits.least_spread)) ** 2)
    chance = np.where(inside, np.exp(evidence - evidence[inside].max()), 0.0)
    chance /= chance.sum()
    best = np.unravel_index(int(np.where(inside, evidence, -np.inf).argmax()), evidence.shape)
    near = np.hypot(right - right[best], high - high[best]) < limits.one_place
    if chance[near].sum() < limits.least_chance or spot[near & inside].max() < limits.least_spot:
        return None
    share = np.where(near, chance, 0.0) / chance[near].sum()
    mean = float((share * right).sum()), float((share * high).sum())
    place = patch.place(*mean)
    if place is None:
        return None
    off = np.stack([right - mean[0], high - mean[1]], axis=-1)
    flat = np.einsum("rc,rci,rcj->ij", share, off, off)
    axes = patch.axes[:2]
    return Observation(place, axes.T @ flat @ axes + limits.floor**2 * (axes.T @ axes), NAVEL_SEEN)
