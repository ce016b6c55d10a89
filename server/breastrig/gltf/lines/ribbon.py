"""A model drawing as narrow ribbons that lie on the skin and ride on the skinned, morphing mesh.

Ribbons of triangles, not glTF line strips: three.js and most viewers that follow it do not skin lines, and
draw them one pixel wide; a fitted model would then show its drawing where the rest pose was.  Each polyline
is cut into short steps, its two edges are put on the template's surface, and every ribbon vertex takes
position, skin weights and all blendshapes of its surface point by barycentric interpolation, lifted a hair
along the normal (which turns with the blendshapes).

How exact.  Skinning an interpolated point is not interpolating skinned points: in the poses of real fits they
are 0.3 mm apart, and 1.5 mm where a triangle has the weights of five bones, of which glTF carries four; enough to sink
under the skin.  Every file that is written for a pose therefore gets rest positions that make its ribbons
`exact_in` that pose.  Tried and dropped: least-squares skin weights over random poses, which gain nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import unit_vectors
from breastrig.geometry.surface_points import SurfacePoints, joined
from breastrig.gltf.skinned import joints_and_weights, normals_of_shapes
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import bone_matrices

WIDTH = 0.002  # m, a surgical marker's line
LIFT = 0.0005  # m, above the skin, so that line and skin do not fight for the same pixel
STEP = 0.004  # m, longest stretch of a ribbon: half an edge of the mesh on the breasts
SAME_PLACE = 1e-6  # m


@dataclass(frozen=True, eq=False)
class Ribbon:
    """2 M vertices: the left and right edge alternating along the line."""

    shape: DrawnShape
    points: SurfacePoints  # (2M,) on the template
    positions: Array  # (2M, 3) m, lifted off the template
    joints: NDArray[np.uint8]  # (2M, 4) bones
    weights: NDArray[np.float32]  # (2M, 4) their weights
    blendshapes: Array  # (S, 2M, 3) m, of the lifted positions
    faces: Integers  # (F, 3)


@dataclass(frozen=True, eq=False)
class _Skin:
    """Data of a rig's template that all ribbons share."""

    search: ClosestPointSearch
    normals: Array  # (V, 3)
    turns: Array  # (S, V, 3) change of the normals with each shape at weight 1


@lru_cache(maxsize=4)
def _skin(rig: Rig) -> _Skin:
    normals = normals_of_shapes(rig)
    return _Skin(ClosestPointSearch(rig.template, rig.faces), normals[0], normals[1:] - normals[0])


@lru_cache(maxsize=16)
def ribbons(rig: Rig, drawing: ModelDrawing) -> tuple[Ribbon, ...]:
    """A ribbon for each shape of the drawing that is more than a single point."""
    made = (_ribbon(rig, shape) for shape in drawing.shapes)
    return tuple(ribbon for ribbon in made if ribbon is not None)


def exact_in(rig: Rig, lines: Sequence[Ribbon], x: RigParameters, mesh: Array) -> list[Array]:
    """(2M, 3) m each: rest positions such that the ribbons, posed by `x`, lie exactly on the (V, 3) mesh, lifted."""
    if not lines:
        return []
    points = joined([line.points for line in lines])
    wanted = points.positions(mesh, rig.faces) + LIFT * points.directions(rig.normals_at(mesh), rig.faces)
    linear, offset = bone_matrices(rig, x)
    weights, joints = (np.concatenate([getattr(line, name) for line in lines]) for name in ("weights", "joints"))
    blend = np.einsum("mi,miab->mab", weights, linear[joints])
    moved = np.einsum("mi,mia->ma", weights, offset[joints])
    shaped = np.einsum("mab,mb->ma", inverses(blend), wanted - moved)
    ends = np.cumsum([len(line.points) for line in lines])[:-1]
    return [
        part - np.tensordot(x.weights, line.blendshapes, axes=1)
        for part, line in zip(np.split(shaped, ends), lines, strict=True)
    ]


def inverses(matrices: Array) -> Array:
    """(M, 3, 3) inverses of (M, 3, 3) linear maps; the nearest to an inverse where one is flat."""
    try:
        return np.asarray(np.linalg.inv(matrices), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrices), dtype=np.float64)


def _ribbon(rig: Rig, shape: DrawnShape) -> Ribbon | None:
    skin = _skin(rig)
    line = _dense(shape.points.positions(rig.template, rig.faces), shape.closed)
    if len(line) < 2:
        return None
    middle = skin.search.query(line)
    facing = middle.on_mesh.directions(skin.normals, rig.faces)
    side = np.cross(facing, _tangents(middle.points, shape.closed))
    side *= 0.5 * WIDTH / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    edges = np.stack([middle.points + side, middle.points - side], axis=1).reshape(-1, 3)
    points = skin.search.query(edges).on_mesh
    corners = rig.faces[points.faces]
    joints, weights = joints_and_weights(np.einsum("mc,mcb->mb", points.barycentric, rig.skin_weights[corners]))
    lifted_shapes = rig.blendshapes[:, corners] + LIFT * skin.turns[:, corners]
    return Ribbon(
        shape=shape,
        points=points,
        positions=points.positions(rig.template, rig.faces) + LIFT * points.directions(skin.normals, rig.faces),
        joints=joints,
        weights=weights,
        blendshapes=np.einsum("mc,smcd->smd", points.barycentric, lifted_shapes),
        faces=_triangles(len(line), shape.closed),
    )


def _dense(points: Array, closed: bool) -> Array:
    """(M, 3): the corners with points in between, no farther apart than STEP; no repeated points."""
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
    return unit_vectors(tangents)


def _triangles(count: int, closed: bool) -> Integers:
    """Two triangles for each stretch between neighbouring points of the line, facing out of the skin."""
    here = np.arange(count if closed else count - 1)
    there = (here + 1) % count
    left, right, next_left, next_right = 2 * here, 2 * here + 1, 2 * there, 2 * there + 1
    first, second = np.stack([left, right, next_right], 1), np.stack([left, next_right, next_left], 1)
    return np.stack([first, second], axis=1).reshape(-1, 3)
