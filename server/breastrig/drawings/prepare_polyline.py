"""Prepares drawn polylines for a transfer: their points and points in between, all on the scan's skin.

Points that are far apart are joined by the shortest path along the fitted model, as a scan's mesh has holes.  All lines
of a drawing are prepared together, which shares what is computed for all points.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadDrawing
from breastrig.correspondence.match import MatchRules, match
from breastrig.drawings.on_skin import check_on_skin
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.polyline import Polyline, arc_lengths, interpolated, parts
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Rig

SPACING = 0.003  # m between points of a line: finer than a pen, coarser than the noise
FAR_APART = 0.015  # m between two points; the skin is 1 mm off a chord of 15 mm where its radius is 3 cm
SKIN_BELOW = MatchRules(method="tree", max_distance=0.02, max_angle=np.pi / 3)


def prepared(rig: Rig, scan: FittedScan, shapes: Sequence[Polyline]) -> list[Polyline]:
    """The shapes with points in between, on the scan's skin where that has any and marked as bridged elsewhere.

    Raises BadDrawing for a given point off the skin that is not said to be bridged.
    """
    points = np.concatenate([shape.points for shape in shapes])
    skipped = np.concatenate([shape.bridged for shape in shapes])
    given = scan.target.search.query(points)
    rows = parts(shapes)
    for shape, part in zip(shapes, rows, strict=True):
        check_on_skin(shape, given.distances[part])
    corners = np.where(skipped[:, None], points, given.points)
    model = ClosestPointSearch(scan.vertices, rig.faces)
    below = model.query(corners).on_mesh
    geodesics = Geodesics(scan.vertices, rig.faces)
    on_model = [below[part] for part in rows]
    lines = [
        _with_points_between(geodesics, shape, corners[part], places)
        for shape, part, places in zip(shapes, rows, on_model, strict=True)
    ]
    own = np.concatenate([given for _, _, given in lines])
    line, hidden = np.concatenate([line for line, _, _ in lines]), np.concatenate([hidden for _, hidden, _ in lines])
    inner = np.flatnonzero(~own)
    line[inner], over_a_hole = _snapped(rig, scan, model, line[inner])
    hidden[inner] |= over_a_hole
    return [  # of points in between no error is known
        replace(shape, points=line[part], bridged=hidden[part], corners=_among(shape.corners, own[part]), error=None)
        for shape, part in zip(shapes, parts(each for each, _, _ in lines), strict=True)
    ]


def _among(corners: tuple[int, ...], own: Booleans) -> tuple[int, ...]:
    """The corners' indices in the resampled line, of which `own` (M,) are the original points."""
    return tuple(np.flatnonzero(own)[list(corners)].tolist())


def _with_points_between(
    geodesics: Geodesics, shape: Polyline, corners: Array, places: SurfacePoints
) -> tuple[Array, Booleans, Booleans]:
    """(M, 3) m, (M,) bridged and (M,) the line's own: its corners with points in between, at most SPACING apart.

    `places` are the model's points next to the corners.
    """
    count = len(corners)
    following = shape.edges[:, 1]
    start, arms = corners[: len(following)], corners[following] - corners[: len(following)]
    gaps = np.linalg.norm(arms, axis=1)
    inner = np.maximum(np.ceil(gaps / SPACING).astype(np.int64), 1) - 1
    far: dict[int, Array] = {}
    for k in np.flatnonzero(gaps > FAR_APART).tolist():
        pair = np.array([k, following[k]])
        far[k] = _between(geodesics, corners[pair], places[pair])
        inner[k] = len(far[k])
    first = np.concatenate([[0], np.cumsum(1 + inner)])  # where each segment begins in the line
    segment = np.repeat(np.arange(len(inner)), 1 + inner)
    step = np.arange(first[-1]) - first[segment]
    line = start[segment] + (step / (1 + inner[segment]))[:, None] * arms[segment]
    for k, path in far.items():
        line[first[k] + 1 : first[k + 1]] = path
    own = step == 0
    bridged = np.where(own, shape.bridged[segment], shape.bridged[segment] | shape.bridged[following[segment]])
    if len(following) < count:  # the end of an open line
        line = np.concatenate([line, corners[-1:]])
        own, bridged = np.append(own, True), np.append(bridged, shape.bridged[-1])
    return line, bridged, own


def _snapped(rig: Rig, scan: FittedScan, model: ClosestPointSearch, points: Array) -> tuple[Array, Booleans]:
    """(M, 3) m points on the skin that faces as the model does, and (M,) which found none and stay."""
    normals = model.query(points).on_mesh.directions(vertex_normals(scan.vertices, rig.faces), rig.faces)
    found = match(scan.target, points, normals, SKIN_BELOW)
    snapped, missed = points.copy(), np.ones(len(points), dtype=np.bool_)
    snapped[found.vertices], missed[found.vertices] = found.points, False
    return snapped, missed


def _between(geodesics: Geodesics, ends: Array, places: SurfacePoints) -> Array:
    """(M, 3) m: points on the shortest path between two points (2, 3), at most SPACING apart, near the skin."""
    path = ends
    with suppress(BadDrawing):  # parts of the model that are not connected: then the chord
        path = np.concatenate([path[:1], geodesics.path(places[[0]], places[[1]]), path[1:]])
    along = arc_lengths(path)
    count = max(1, int(np.ceil(along[-1] / SPACING)))
    inner = np.linspace(0.0, along[-1], count + 1)[1:-1]
    return interpolated(inner, along, path)
