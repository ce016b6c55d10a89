"""Half way between notch and xiphoid along the skin's profile: known where both are marked by a cross.

Nothing on the skin shows it, and of the form it is as unsure as of the notch; two crosses say it to some millimetres.
"""

import numpy as np

from breastrig.colour.features.crosses import CrossObservation
from breastrig.colour.features.patch import ColouredSkin
from breastrig.core.arrays import Array

STEP = 0.003  # m, between the places of the profile; a breast bone is flat
BEYOND = 0.006  # m, of the picture over both ends
LEAST_SEEN = 0.9  # share of the profile that the scan must show


def between_crosses(
    skin: ColouredSkin, notch: CrossObservation, xiphoid: CrossObservation, front: Array, error: float
) -> CrossObservation | None:
    """The middle of the profile from cross to cross, seen along `front` (3,); None where too little skin is seen.

    `error` (m) is how far off it is, root mean square, from exact ends; that of the crosses adds to it.
    """
    way = notch.place - xiphoid.place
    length = float(np.linalg.norm(way))
    up = way / max(length, 1e-12)
    outwards = front - (front @ up) * up
    outwards /= max(float(np.linalg.norm(outwards)), 1e-12)
    patch = skin.patch(0.5 * (notch.place + xiphoid.place), outwards, up, 0.5 * length + BEYOND, STEP)
    heights = np.linspace(0.5 * length, -0.5 * length, max(round(length / STEP), 2))
    profile = np.array([place for place in (patch.place(0.0, height) for height in heights) if place is not None])
    if len(profile) < LEAST_SEEN * len(heights):
        return None
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    middle = np.array([np.interp(0.5 * along[-1], along, profile[:, axis]) for axis in range(3)])
    covariance = 0.25 * (notch.covariance + xiphoid.covariance) + error**2 / 2.0 * np.eye(3)
    return CrossObservation(middle, covariance)
