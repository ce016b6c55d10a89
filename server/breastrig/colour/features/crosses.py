"""Crosses that the surgeon drew: one near a landmark of the midline, as the form has it, marks that landmark.

Surgeons mark notch and xiphoid before they draw anything else. Crosses elsewhere mark other things, so only those near
the midline and within the form's uncertainty of one of the two count. Ink is searched around these places only, which
takes a tenth of the time of the whole scan.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from breastrig.colour.features.limits import CrossLimits
from breastrig.colour.features.observation import Observation
from breastrig.colour.features.patch import ColouredSkin
from breastrig.colour.ink.find_ink import find_ink
from breastrig.colour.ink.kinds import Kind
from breastrig.core.arrays import Array
from breastrig.core.errors import BreastRigError
from breastrig.geometry.polyline import arc_lengths, point_along
from breastrig.scan.scan import Scan

CROSS_SEEN, BETWEEN_SEEN = "marked by a cross", "between two crosses"


def marked_by_crosses(
    scan: Scan,
    expected: Mapping[str, Array],
    spreads: Mapping[str, float],
    left: Array,
    limits: CrossLimits,
    image: NDArray[np.uint8] | None = None,
) -> dict[str, Observation]:
    """The `expected` places (3,) m on the midline that a cross marks.

    `spreads` (m) are their usual errors, `left` (3,) is the body's unit direction, `image` the decoded texture (H, W,
    3), if it is.
    """
    if scan.colour_kind != "texture" or not expected:
        return {}
    part = _around(scan, np.array(list(expected.values())), limits.around)
    try:
        crosses = [each.line.points.mean(axis=0) for each in find_ink(part, image=image) if each.kind is Kind.CROSS]
    except (BreastRigError, ValueError):
        return {}
    found = {}
    for name, place in expected.items():
        near = [cross for cross in crosses if abs((cross - place) @ left) < limits.aside]
        near = [cross for cross in near if np.linalg.norm(cross - place) < limits.farthest * spreads[name]]
        if near and np.ptp(near, axis=0).max() < limits.one_place:
            found[name] = Observation(np.mean(near, axis=0), limits.error**2 / 2.0 * np.eye(3), CROSS_SEEN)
    return found


def _around(scan: Scan, places: Array, reach: float) -> Scan:
    """The triangles with a corner within `reach` (m) of one of (M, 3) places."""
    near = (np.linalg.norm(scan.vertices[:, None] - places, axis=2) < reach).any(axis=1)
    faces = scan.faces[near[scan.faces].any(axis=1)]
    used, corners = np.unique(faces, return_inverse=True)
    return replace(
        scan,
        vertices=scan.vertices[used],
        faces=corners.reshape(-1, 3),
        uv=None if scan.uv is None else scan.uv[used],
        colours=None if scan.colours is None else scan.colours[used],
    )


STEP = 0.003  # m, between the places of the profile; a breast bone is flat
BEYOND = 0.006  # m, of the picture over both ends
LEAST_SEEN = 0.9  # share of the profile that the scan must show


def between_crosses(
    skin: ColouredSkin, notch: Observation, xiphoid: Observation, front: Array, error: float
) -> Observation | None:
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
    middle = point_along(profile, 0.5 * arc_lengths(profile)[-1])
    covariance = 0.25 * (notch.covariance + xiphoid.covariance) + error**2 / 2.0 * np.eye(3)
    return Observation(middle, covariance, BETWEEN_SEEN)
