"""A line as it was drawn, made ready to be carried: its own corners, points in between, all on the scan's skin.

Corners that are far apart are joined by the shortest way along the fitted model: a straight chord would leave the
skin, across the cleavage even for the other breast.  The model and not the scan, because a scan's mesh has holes and
edges of three triangles, over which exact geodesics cannot be measured.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadDrawing
from breastrig.correspondence.match import MatchRules, match
from breastrig.drawings.carry import FittedScan
from breastrig.drawings.drawing_file import ScanShape
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Rig

SPACING = 0.003  # m between points of a line: finer than a pen, coarser than the noise
FAR_APART = 0.015  # m between two corners; the skin is 1 mm off a chord of 15 mm where its radius is 3 cm
OFF_THE_SKIN = 0.005  # m; a drawn point farther from its scan belongs to another scan, frame or unit
SKIN_BELOW = MatchRules(method="tree", max_distance=0.02, max_angle=np.pi / 3)


def on_the_skin(rig: Rig, scan: FittedScan, shape: ScanShape) -> ScanShape:
    """The shape with points in between, on the scan's skin where that has any and marked as bridged elsewhere.

    Raises BadDrawing for a given point off the skin that is not said to be bridged.
    """
    given = scan.target.search.query(shape.points)
    off = np.flatnonzero((given.distances > OFF_THE_SKIN) & ~shape.bridged)
    if len(off):
        raise BadDrawing(
            f'Point {off[0] + 1} of "{shape.name}" is {1e3 * given.distances[off[0]]:.0f} mm away from the scan; '
            "draw on the skin, and check that drawing and scan have the same unit and frame."
        )
    corners = np.where(shape.bridged[:, None], shape.points, given.points)
    model = ClosestPointSearch(scan.vertices, rig.faces)
    count = len(corners)
    following = np.roll(np.arange(count), -1)[: count if shape.closed and count > 2 else -1]
    points, bridged, own = [], [], []
    for start in range(count):
        points.append(corners[[start]])
        bridged.append(shape.bridged[[start]])
        own.append(np.ones(1, dtype=np.bool_))
        if start < len(following):
            end = following[start]
            points.append(_between(rig, scan, model, corners[start], corners[end]))
            bridged.append(np.repeat(shape.bridged[start] or shape.bridged[end], len(points[-1])))
            own.append(np.zeros(len(points[-1]), dtype=np.bool_))
    line, hidden = np.concatenate(points), np.concatenate(bridged)
    inner = np.flatnonzero(~np.concatenate(own))
    line[inner], over_a_hole = _settled(rig, scan, model, line[inner])
    hidden[inner] |= over_a_hole
    return replace(shape, points=line, bridged=hidden)


def _settled(rig: Rig, scan: FittedScan, model: ClosestPointSearch, points: Array) -> tuple[Array, Booleans]:
    """(M, 3) m points on the skin that faces as the model does, and (M,) which found none and stay."""
    at = model.query(points)
    normals = SurfacePoints(at.faces, at.barycentric).positions(vertex_normals(scan.vertices, rig.faces), rig.faces)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    found = match(scan.target, points, normals, SKIN_BELOW)
    settled, missed = points.copy(), np.ones(len(points), dtype=np.bool_)
    settled[found.vertices], missed[found.vertices] = found.points, False
    return settled, missed


def _between(rig: Rig, scan: FittedScan, model: ClosestPointSearch, start: Array, end: Array) -> Array:
    """(M, 3) m: points between two corners, at most SPACING apart, near the skin."""
    way = np.stack([start, end])
    if np.linalg.norm(end - start) > FAR_APART:
        at = model.query(way)
        places = [SurfacePoints(at.faces[[k]], at.barycentric[[k]]) for k in range(2)]
        with suppress(BadDrawing):  # parts of the model that are not connected: then the chord
            way = np.concatenate([way[:1], Geodesics(scan.vertices, rig.faces).path(*places), way[1:]])
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(1, int(np.ceil(length[-1] / SPACING)))
    inner = np.linspace(0.0, length[-1], count + 1)[1:-1]
    return np.stack([np.interp(inner, length, way[:, axis]) for axis in range(3)], axis=1)
