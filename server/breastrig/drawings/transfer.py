"""Transfers a drawing from one scan to another.

Between two stances of one patient the skin is followed (skin_maps/skin_map.py); between two patients the place on the
model.  Every point ends on the target's skin; over a hole the line goes on at the height of the hole's rims and is
marked as bridged.  Each point has the distances of the two fits from their scans there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.match import MatchRules, match
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.prepare_polyline import prepared
from breastrig.drawings.project_drawing import LineNearSkin, smoothed_on_skin
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, shared_marks
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import unit_vectors, vertex_normals
from breastrig.geometry.polyline import Polyline, parts
from breastrig.rig.model import Rig

STEP = 0.002  # m, for the tangents of a map, which bends over centimetres
ROUNDS = 3  # to find the place of the model over which a scan's point stands; the third moves it by micrometres
NEAREST_SKIN = MatchRules(method="tree", max_distance=0.02, max_angle=np.pi / 3)
ALONG_THE_NORMAL = MatchRules(method="rays", max_distance=0.03, max_angle=np.pi / 3)

PointMap = Callable[[Array, Array], tuple[Array, Array]]  # (M, 3) points and normals on A -> near B's skin, normals


@dataclass(frozen=True, eq=False)
class TransferredLine:
    """A polyline of M points on scan B, and how well the two fits lie on their scans there."""

    line: Polyline
    distance_from: Array  # (M,) m between A's scan and A's fitted model there; nan without skin
    distance_to: Array  # (M,) m between B's scan and B's fitted model there; nan without skin


def transferred(
    rig: Rig, a: FittedScan, b: FittedScan, shapes: Sequence[Polyline], other_patient: bool = False
) -> tuple[TransferredLine, ...]:
    """The shapes on scan A, at the same skin of scan B or, for another patient, at the same place of the model.

    Raises BadDrawing for a point off A's skin that is not said to be bridged, and for fits off their scans.
    """
    lines = prepared(rig, a, shapes)
    points = np.concatenate([line.points for line in lines])
    skipped = np.concatenate([line.bridged for line in lines])
    near, facing, there, bridged = _mapped(rig, a, b, points, other_patient, skipped)
    rows = parts(lines)
    smooth = np.zeros(len(points), dtype=np.bool_)
    near_skin = [  # a line is smoother than its points alone, and does not step onto an arm
        LineNearSkin(near[part], facing[part], there[part] - near[part], ~bridged[part], smooth[part], line.closed)
        for line, part in zip(lines, rows, strict=True)
    ]
    for part, (on_b, met) in zip(rows, smoothed_on_skin(b.target, near_skin), strict=True):
        there[part], bridged[part] = on_b, ~met
    models = [ClosestPointSearch(each.vertices, rig.faces) for each in (a, b)]
    gaps = [model.query(each).distances for model, each in zip(models, (points, there), strict=True)]
    gaps[0][skipped], gaps[1][bridged] = np.nan, np.nan
    marks = () if other_patient else shared_marks(rig, a, b).followed
    errors = carried_errors(rig, a, b, points, there, marks=marks)
    return tuple(
        TransferredLine(
            replace(line, points=there[part], bridged=bridged[part], error=None if errors is None else errors[part]),
            gaps[0][part],
            gaps[1][part],
        )
        for line, part in zip(lines, rows, strict=True)
    )


def points_carried(
    rig: Rig, a: FittedScan, b: FittedScan, points: Array, other_patient: bool = False
) -> tuple[Array, Booleans]:
    """(M, 3) m: where (M, 3) m points of A's skin are on scan B, each by itself, and (M,) which met no skin there.

    Raises BadDrawing for fits off their scans.
    """
    on_skin = np.zeros(len(points), dtype=np.bool_)
    _, _, there, bridged = _mapped(rig, a, b, points, other_patient, on_skin)
    return there, bridged


def _mapped(
    rig: Rig, a: FittedScan, b: FittedScan, points: Array, other_patient: bool, bridged: Booleans
) -> tuple[Array, Array, Array, Booleans]:
    """(M, 3) m before B's skin is met, (M, 3) normals there, (M, 3) m after, and (M,) where none is met.

    `bridged` (M,) says which points are not on A's skin.
    """
    on_a = a.target.search.query(points)
    normals = unit_vectors(a.target.surface_at(on_a.faces, on_a.barycentric)[1])
    model = ClosestPointSearch(a.vertices, rig.faces)
    if bridged.any():  # without skin the model says which way is out
        places = model.query(points[bridged]).on_mesh
        normals[bridged] = places.directions(vertex_normals(a.vertices, rig.faces), rig.faces)
    mapped = _model_map(rig, a, b, model) if other_patient else _skin_map(rig, a, b)
    near, facing = mapped(points, normals)
    there = near.copy()
    missing = np.arange(len(near))
    for rules in (ALONG_THE_NORMAL, NEAREST_SKIN) if other_patient else (NEAREST_SKIN, ALONG_THE_NORMAL):
        found = match(b.target, near[missing], facing[missing], rules)
        there[missing[found.vertices]] = found.points
        missing = np.delete(missing, found.vertices)
    no_skin = np.zeros(len(near), dtype=np.bool_)
    no_skin[missing] = True
    return near, facing, there, no_skin


def _skin_map(rig: Rig, a: FittedScan, b: FittedScan) -> PointMap:
    """A map of points to the same skin in another stance; see skin_map.carried for the direction."""
    backwards = a.stance == "supine" and b.stance != "supine"
    skin = SkinMap(rig, b, a) if backwards else SkinMap(rig, a, b)
    move = skin.moved_back if backwards else skin.moved

    def mapped(points: Array, normals: Array) -> tuple[Array, Array]:
        near = move(points)
        side = np.eye(3)[np.abs(normals).argmin(axis=1)]
        first = unit_vectors(np.cross(normals, side))
        second = np.cross(normals, first)
        along, across = (move(points + STEP * each) - near for each in (first, second))
        return near, unit_vectors(np.cross(along, across))

    return mapped


def _model_map(rig: Rig, a: FittedScan, b: FittedScan, model: ClosestPointSearch) -> PointMap:
    """A map of points to the same place of the model: the model's point below each, moved to B."""
    turned = vertex_normals(a.vertices, rig.faces)
    there = vertex_normals(b.vertices, rig.faces)

    def mapped(points: Array, _normals: Array) -> tuple[Array, Array]:
        asked = points
        for _ in range(ROUNDS):
            found = model.query(asked)
            places = found.on_mesh
            normals = places.directions(turned, rig.faces)
            gap = points - found.points
            asked = found.points + gap - np.einsum("mi,mi->m", gap, normals)[:, None] * normals
        return places.positions(b.vertices, rig.faces), places.directions(there, rig.faces)

    return mapped
