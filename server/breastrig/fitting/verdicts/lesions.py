"""Whether what a label map shows inside the body lies in the fitted one, near its breasts."""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.verdicts.reasons import Reason
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.near_breasts import OUTSIDE, near_breasts
from breastrig.scan.piece import BallInside

COMPARE = ("compare model and scan",)


def of_lesions(rig: Rig, vertices: Array, lesions: Sequence[BallInside]) -> tuple[tuple[Reason, ...], bool]:
    """(reasons, whether a lesion lies outside) for the (V, 3) m fitted skin: then the fit lies elsewhere."""
    if not lesions:
        return (), False
    centers = np.array([each.center for each in lesions])
    nearest = ClosestPointSearch(vertices, rig.faces).query(centers)
    above = np.einsum("li,li->l", centers - nearest.points, face_normals(vertices, rig.faces)[nearest.faces])
    outside = (above > 0.0) & (nearest.distances > OUTSIDE)
    is_near: Booleans = np.any(near_breasts(rig)[rig.faces[nearest.faces]], axis=1)
    reasons = [
        Reason(f"{each.name} lies {1e3 * distance:.0f} mm outside the fitted skin", COMPARE)
        for each, distance, out in zip(lesions, nearest.distances, outside, strict=True)
        if out
    ]
    reasons += [
        Reason(f"{each.name} lies far from the breasts of the fitted model", COMPARE)
        for each, near, out in zip(lesions, is_near, outside, strict=True)
        if not near and not out
    ]
    return tuple(reasons), bool(outside.any())
