"""Symmetry of a patient's own two breasts, as published series state it: of volume, and of shape.

Volume: the smaller over the larger.  Shape: root mean square distance from the left breast's skin, along its normal, to
the right one's mirrored in the fitted model's median plane.
"""

import numpy as np

from breastrig.core.stances import SIDES
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.report.bands import Points, banded, ratio_half_width
from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import measure_calibration
from breastrig.report.stance import Stance
from breastrig.report.table import Row
from breastrig.report.visits.alignment import Alignment
from breastrig.report.visits.change import SEEN, visit_calibration, way_to
from breastrig.report.volume import seen_share, vertices_within

VOLUME, SHAPE = "volume_symmetry", "shape_symmetry"
STAYS = Alignment(np.eye(3), np.zeros(3), 0.0)


def symmetry_rows(stance: Stance, rows: tuple[Row, ...]) -> list[Row]:
    """The rows of both; none of volume where a breast's is not known or below zero, none of shape where unseen."""
    return [*_volume(stance, rows), *_shape(stance)]


def _volume(stance: Stance, rows: tuple[Row, ...]) -> list[Row]:
    row, known = next((row for row in rows if row.measure == "volume"), None), measure_calibration(stance.rig)
    if row is None or known is None or row.left is None or row.right is None:
        return []
    pair = row.left.value, row.right.value
    if min(pair) <= 0.0:
        return []
    points = Points((row.left.margin, row.right.margin), known.sides.volume)
    half = ratio_half_width(pair, ((), ()), points, None)
    value = banded(min(pair) / max(pair), half, 0.0, 1.0)
    method = "smaller over larger volume"
    return [Row(VOLUME, "Volume symmetry", "ratio", "1", None, None, value, row.landmarks, method)]


def _shape(stance: Stance) -> list[Row]:
    rig, known = stance.rig, visit_calibration(stance.rig)
    inside = vertices_within(rig, "L")
    if known is None or inside is None or min(seen_share(stance, side) or 0.0 for side in SIDES) < SEEN:
        return []
    frame = body_frame(rig, stance.vertices)
    out = frame.axes[:, 0]
    mirrored = stance.vertices - 2.0 * frame.lateral(stance.vertices)[:, None] * out
    shown = np.flatnonzero(inside & np.isfinite(stance.distances))
    normals = vertex_normals(stance.vertices, rig.faces)[shown]
    search = ClosestPointSearch(mirrored, rig.faces[:, ::-1])
    way, faces = way_to(stance.vertices[shown], normals, search, STAYS)
    way = way[np.isfinite(way) & np.isfinite(stance.distances)[rig.faces[faces]].all(axis=1)]
    if len(way) < SEEN * inside.sum():
        return []
    value = banded(1e3 * float(np.sqrt(np.mean(way**2))), 1e3 * known.shape)
    method = "root mean square distance along the normal from the left breast to the right one, mirrored"
    return [Row(SHAPE, "Shape symmetry", "surface", "mm", None, None, value, ("model",), method)]
