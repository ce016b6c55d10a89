"""The areola and nipple of one breast: rings of vertices around the tip, so that they can be moved and resized.

The half body is cut along a circle around the nipple's axis and remeshed with that hole; the hole is then filled
with concentric rings whose vertices lie on the reference surface straight below them.
"""

import numpy as np
from scipy import sparse

from steps.source import Array, Integers
from steps.surface import Surface


def vertex_normals(vertices: Array, triangles: Integers) -> Array:
    """(V, 3) unit normals, area weighted."""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    result = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(result, triangles[:, i], cross)
    return np.asarray(result / np.maximum(np.linalg.norm(result, axis=1, keepdims=True), 1e-30))


def nipple_axis(surface: Surface, tip: Array, radius: float) -> Array:
    """(3,) the mean normal of the skin within `radius` (m) of the tip."""
    near = np.linalg.norm(surface.vertices - tip, axis=1) < radius
    mean = vertex_normals(surface.vertices, surface.triangles)[near].mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean))


def distance_from_axis(points: Array, tip: Array, axis: Array) -> Array:
    """(M,) m."""
    offset = points - tip
    return np.asarray(np.linalg.norm(offset - (offset @ axis)[:, None] * axis, axis=1))


def axis_frame(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors across the axis: towards the patient's left, and up."""
    up = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    up /= np.linalg.norm(up)
    return np.cross(up, axis), up


def _below(points: Array, axis: Array, surface: Surface) -> tuple[Integers, Array]:
    """((M, 3) vertices, (M, 3) mixture) of the surface hit first by rays from far outside against the axis."""
    t = surface.triangles
    side, up = axis_frame(axis)
    flat = np.stack([surface.vertices @ side, surface.vertices @ up], axis=1)
    depth = surface.vertices @ axis
    a, b, c = (flat[t[:, i]] for i in range(3))
    det = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    index = np.zeros((len(points), 3), dtype=np.int64)
    share = np.zeros((len(points), 3))
    safe = np.where(det > 1e-16, det, 1.0)
    for m, p in enumerate(points):
        x, y = p @ side - a[:, 0], p @ up - a[:, 1]
        s = (x * (c[:, 1] - a[:, 1]) - y * (c[:, 0] - a[:, 0])) / safe
        u = (y * (b[:, 0] - a[:, 0]) - x * (b[:, 1] - a[:, 1])) / safe
        height = (1 - s - u) * depth[t[:, 0]] + s * depth[t[:, 1]] + u * depth[t[:, 2]]
        hit = (det > 1e-16) & (s >= -1e-9) & (u >= -1e-9) & (s + u <= 1 + 1e-9)
        best = int(np.where(hit, height, -np.inf).argmax())
        index[m], share[m] = t[best], [1 - s[best] - u[best], s[best], u[best]]
    return index, share


def _stitch(outer: Integers, outer_angle: Array, inner: Integers, inner_angle: Array) -> list[tuple[int, int, int]]:
    """Triangles between two rings that both run counter-clockwise seen from outside."""
    turn = 2 * np.pi
    start = outer_angle[0]
    shift = (inner_angle - start) % turn
    first = int(np.minimum(shift, turn - shift).argmin())
    inner, inner_angle = np.roll(inner, -first), np.roll(inner_angle, -first)
    along_outer = np.append((outer_angle - start) % turn, turn)
    offset = (inner_angle[0] - start + np.pi) % turn - np.pi
    along_inner = offset + np.append((inner_angle - inner_angle[0]) % turn, turn)
    result = []
    i = j = 0
    while i < len(outer) or j < len(inner):
        a, b = int(outer[i % len(outer)]), int(inner[j % len(inner)])
        forward = j >= len(inner) or (
            i < len(outer) and along_outer[i] + along_outer[i + 1] <= along_inner[j] + along_inner[j + 1]
        )
        if forward:
            i += 1
            result.append((a, int(outer[i % len(outer)]), b))
        else:
            j += 1
            result.append((a, int(inner[j % len(inner)]), b))
    return result


def filled(
    half: Surface, hole: Integers, reference: Surface, tip: Array, axis: Array, rings: list[tuple[float, int]]
) -> tuple[Surface, list[Integers]]:
    """The half body with the hole (its border vertices, any order) closed by `rings` of (radius m, count) and the tip.

    Also the rings' vertices, the hole's border first and the tip last.
    """
    side, up = axis_frame(axis)

    def angles(points: Array) -> Array:
        return np.asarray(np.arctan2((points - tip) @ up, (points - tip) @ side) % (2 * np.pi))

    order = angles(half.vertices[hole]).argsort()
    ring_vertices = [hole[order]]
    ring_angles = [angles(half.vertices[hole])[order]]
    new_points: list[Array] = []
    triangles = [tuple(t) for t in half.triangles]
    count = len(half.vertices)
    for number, (radius, size) in enumerate(rings):
        angle = (np.arange(size) + 0.5 * (number % 2)) * 2 * np.pi / size
        points = tip + radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        ids = count + len(new_points) + np.arange(size)
        new_points += list(points)
        ring_vertices.append(ids)
        ring_angles.append(angle)
    for (outer, outer_angle), (inner, inner_angle) in zip(
        zip(ring_vertices[:-1], ring_angles[:-1], strict=True), zip(ring_vertices[1:], ring_angles[1:], strict=True),
        strict=True,
    ):  # fmt: skip
        triangles += _stitch(outer, outer_angle, inner, inner_angle)
    last, tip_id = ring_vertices[-1], count + len(new_points)
    new_points.append(tip)
    triangles += [(int(a), int(b), tip_id) for a, b in zip(last, np.roll(last, -1), strict=True)]
    ring_vertices.append(np.array([tip_id]))
    index, share = _below(np.array(new_points), axis, reference)
    rows = np.repeat(np.arange(len(new_points)), 3)
    extra = sparse.csr_matrix((share.ravel(), (rows, index.ravel())), (len(new_points), len(reference.vertices)))
    return (
        Surface(
            np.concatenate([half.vertices, extra @ reference.vertices]),
            np.array(triangles, dtype=np.int64),
            sparse.vstack([half.mix, extra @ reference.mix]).tocsr(),
        ),
        ring_vertices,
    )
