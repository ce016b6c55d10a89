"""A model drawing as narrow ribbons that lie on the skin and ride on the skinned, morphing mesh.

Ribbons of triangles, not glTF line strips: three.js and most viewers that follow it do not skin lines, and
draw them one pixel wide; a fitted model would then show its drawing where the rest pose was.  Each polyline
is cut into short steps, its two edges are put on the template's surface, and every ribbon vertex takes
position, skin weights and all blendshapes of its surface point by barycentric interpolation, lifted a hair
along the normal.  Interpolated weights under linear skinning are not exactly the interpolated posed vertices;
the tests hold the difference under 0.3 mm on the torso.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig

WIDTH = 0.002  # m, a surgical marker's line
LIFT = 0.0005  # m, above the skin, so that line and skin do not fight for the same pixel
STEP = 0.004  # m, longest stretch of a ribbon: half an edge of the mesh on the breasts
CANDIDATES = 16  # triangles looked at for each closest point; see geometry/closest_point.py
SAME_PLACE = 1e-6  # m


@dataclass(frozen=True, eq=False)
class Ribbon:
    """2 M vertices: the left and right edge alternating along the line."""

    points: SurfacePoints  # (2M,) on the template
    positions: Array  # (2M, 3) m, lifted off the template
    skin_weights: Array  # (2M, B) interpolated
    blendshapes: Array  # (S, 2M, 3) m interpolated
    faces: Integers  # (F, 3)


def ribbon(rig: Rig, search: ClosestPointSearch, shape: DrawnShape) -> Ribbon | None:
    """The ribbon of one drawn shape; None when the shape is a single point.  `search` is over the template."""
    line = _dense(shape.points.positions(rig.template, rig.faces), shape.closed)
    if len(line) < 2:
        return None
    normals = vertex_normals(rig.template, rig.faces)
    middle = search.query(line, CANDIDATES)
    facing = SurfacePoints(middle.faces, middle.barycentric).positions(normals, rig.faces)
    side = np.cross(facing, _tangents(middle.points, shape.closed))
    side *= 0.5 * WIDTH / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    edges = np.stack([middle.points + side, middle.points - side], axis=1).reshape(-1, 3)
    found = search.query(edges, CANDIDATES)
    points = SurfacePoints(found.faces, found.barycentric)
    normal = points.positions(normals, rig.faces)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return Ribbon(
        points=points,
        positions=points.positions(rig.template, rig.faces) + LIFT * normal,
        skin_weights=np.einsum("mc,mcb->mb", points.barycentric, rig.skin_weights[rig.faces[points.faces]]),
        blendshapes=np.einsum("mc,smcd->smd", points.barycentric, rig.blendshapes[:, rig.faces[points.faces]]),
        faces=_triangles(len(line), shape.closed),
    )


def _dense(points: Array, closed: bool) -> Array:
    """(M, 3): the same corners, cut so that no stretch is longer than STEP; no repeated points."""
    corners = np.concatenate([points, points[:1]]) if closed else points
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    pieces = [
        corners[i]
        + np.linspace(0.0, 1.0, int(np.ceil(length / STEP)), endpoint=False)[:, None] * (corners[i + 1] - corners[i])
        for i, length in enumerate(steps)
        if length > SAME_PLACE
    ]
    if not closed or not pieces:
        pieces.append(corners[-1:])
    return np.concatenate(pieces)


def _tangents(points: Array, closed: bool) -> Array:
    """(M, 3) unit directions of the line at its points."""
    if closed:
        tangents = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    else:
        tangents = np.concatenate([points[1:], points[-1:]]) - np.concatenate([points[:1], points[:-1]])
    return np.asarray(tangents / np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-12))


def _triangles(count: int, closed: bool) -> Integers:
    """Two triangles for each stretch between neighbouring points of the line, facing out of the skin."""
    here = np.arange(count if closed else count - 1)
    there = (here + 1) % count
    left, right, next_left, next_right = 2 * here, 2 * here + 1, 2 * there, 2 * there + 1
    first, second = np.stack([left, right, next_right], 1), np.stack([left, next_right, next_left], 1)
    return np.stack([first, second], axis=1).reshape(-1, 3)
