"""One breast as a block of tetrahedra on the rig's template, and that block in any body on the same template.

The skin around a breast, from the midline to behind the armpit, is sampled coarsely and joined to the chest wall by
columns of prisms, three tetrahedra each.  The wall is the skin without its breast, a thin-plate sheet over the
footprint, moved inwards.  The same block serves every body, so that bodies are compared node by node.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import Delaunay, cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.rig.model import Rig

AROUND = 0.045  # m of skin around the breast that may move
SPACING = 0.02  # m between the columns
SHARES = (0.0, 0.35, 1.0)  # of the way from wall to skin at which the layers meet
BRIDGE = 0.038  # m, of an edge of the border beyond which there is no skin behind it
NEAR = 0.08  # m around the breast from which the wall's sheet is made
TRUNK = (0.0, -0.03)  # m: x and z of the axis around which skin is unrolled ...
RADIUS = 0.14  # m: ... and the trunk's radius
OF_AN_ARM = 0.25  # skin weight from which on a vertex is the arm's
MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class BreastMesh:
    """Of one side; V vertices of the rig, C columns, L + 1 points in each."""

    side: str
    skin: Integers  # (P,) vertices of the rig within the block
    breast: Booleans  # (P,) which of them are the breast
    columns: Integers  # (C,) vertices of the rig with a column
    triangles: Integers  # (F, 3) of columns, counter-clockwise from outside
    tetrahedra: Integers  # (T, 4) of the (L + 1) * C points of `block`, the wall's first
    held: Booleans  # ((L + 1) * C,) the wall and the rim
    located: tuple[Integers, Array]  # (P,) triangle and (P, 3) barycentric coordinates of each skin vertex
    near: Integers  # (R,) vertices around the breast
    plane: Array  # (V, 2) m, the rig's skin unrolled: around the trunk and along it

    @property
    def surface(self) -> Integers:
        """(F, 3) triangles of the block's points that are skin."""
        return (len(SHARES) - 1) * len(self.columns) + self.triangles


def breast_mesh(rig: Rig, side: str) -> BreastMesh:
    """Of "L" or "R"; the rig needs its region breast_L, and breast_R is its mirror image."""
    if side == "R":
        return _mirrored(breast_mesh(rig, "L"), rig)
    template, breast = rig.template, rig.regions["breast_L"]
    plane = np.stack(
        [RADIUS * np.arctan2(template[:, 0] - TRUNK[0], template[:, 2] - TRUNK[1]), template[:, 1]], axis=1
    )
    away = cKDTree(template[breast]).query(template)[0]
    front = (rig.skin_weights[:, rig.bone_names.index("upper_arm_L")] < OF_AN_ARM) & (template[:, 2] > TRUNK[1])
    inside = front & (away < AROUND) & (template[:, 0] > -1e-6)
    cut = inside[rig.faces].any(axis=1) & ~inside[rig.faces].all(axis=1)
    border = inside & np.isin(np.arange(len(template)), rig.faces[cut])
    columns = _spread(template, np.concatenate([np.flatnonzero(border), np.flatnonzero(inside & ~border)]))
    triangles = _triangles(plane[columns])
    used = np.unique(triangles)
    columns, triangles = columns[used], np.searchsorted(used, triangles)
    edges, counts = np.unique(
        np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    held = np.zeros((len(SHARES), len(columns)), dtype=np.bool_)
    held[0] = True
    held[:, np.unique(edges[counts == 1])] = True
    around = front & (away < NEAR) & (template[:, 0] > -AROUND)
    around[np.concatenate([breast, rig.mirror_vertices[breast]])] = False
    skin = np.flatnonzero(inside)
    return BreastMesh(
        side="L",
        skin=skin,
        breast=np.isin(skin, breast),
        columns=columns,
        triangles=triangles,
        tetrahedra=_prisms(triangles, len(columns)),
        held=held.ravel(),
        located=_located(plane[skin], plane[columns], triangles),
        near=np.flatnonzero(around),
        plane=plane,
    )


def chest_wall(mesh: BreastMesh, vertices: Array, depth: float) -> Array:
    """(C, 3) m: the wall under each column of a body with (V, 3) m vertices, `depth` m under its sheet of skin."""
    sheet = RBFInterpolator(mesh.plane[mesh.near], vertices[mesh.near], kernel="thin_plate_spline", smoothing=1e-5)
    at, step = mesh.plane[mesh.columns], 0.002 * np.eye(2)
    along, up = (sheet(at + one) - sheet(at - one) for one in step)
    inwards = np.cross(up, along)
    return np.asarray(sheet(at) + depth * inwards / np.linalg.norm(inwards, axis=1, keepdims=True))


def block(wall: Array, skin: Array) -> Array:
    """((L + 1) * C, 3) m: the points between (C, 3) m wall and skin."""
    return np.concatenate([wall + share * (skin - wall) for share in SHARES])


def _mirrored(mesh: BreastMesh, rig: Rig) -> BreastMesh:
    """Skin keeps its order, so that the sides' skins are each other's mirror images row by row."""
    other, plane = rig.mirror_vertices, mesh.plane * np.array([-1.0, 1.0])
    return replace(
        mesh,
        side="R",
        skin=other[mesh.skin],
        columns=other[mesh.columns],
        triangles=mesh.triangles[:, ::-1],
        tetrahedra=mesh.tetrahedra[:, [0, 2, 1, 3]],
        located=(mesh.located[0], mesh.located[1][:, ::-1]),
        near=other[mesh.near],
        plane=plane[other],
    )


def _spread(points: Array, order: Integers) -> Integers:
    """Those of the ordered points that keep SPACING from all chosen before."""
    chosen: list[int] = []
    for point in order.tolist():
        if not chosen or np.linalg.norm(points[chosen] - points[point], axis=1).min() > SPACING:
            chosen.append(point)
    return np.array(chosen, dtype=np.int64)


def _triangles(plane: Array) -> Integers:
    """(F, 3) Delaunay's in the (C, 2) plane, without those that bridge the bays of the border."""
    found = Delaunay(plane).simplices
    area = _cross(plane[found[:, 1]] - plane[found[:, 0]], plane[found[:, 2]] - plane[found[:, 0]])
    found[area < 0.0] = found[area < 0.0][:, ::-1]
    while True:
        ends = np.sort(found[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, which, counts = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        bridge = (counts[which] == 1) & (np.linalg.norm(plane[ends[:, 0]] - plane[ends[:, 1]], axis=1) > BRIDGE)
        if not bridge.any():
            return np.asarray(found, dtype=np.int64)
        found = found[~bridge.reshape(-1, 3).any(axis=1)]


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _located(points: Array, corners: Array, triangles: Integers) -> tuple[Integers, Array]:
    """The triangle that holds each (P, 2) point, or the nearest one, and barycentric coordinates inside."""
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    p = points[:, None]
    parts = np.stack([_cross(b - p, c - p), _cross(c - p, a - p), _cross(a - p, b - p)], axis=2)
    parts = np.clip(parts / _cross(b - a, c - a)[:, None], -10.0, 10.0)
    best = parts.min(axis=2).argmax(axis=1)
    share = np.clip(parts[np.arange(len(points)), best], 0.0, 1.0)
    return best, share / share.sum(axis=1, keepdims=True)


def _prisms(triangles: Integers, count: int) -> Integers:
    """(T, 4) of positive volume; every wall between prisms is cut from its column of the lower number upwards."""
    order = np.sort(triangles, axis=1)
    a, b, c = triangles.T
    turned = (b > a).astype(int) + (c > b) + (a > c) == 1  # sorting has changed their sense
    found = []
    for layer in range(len(SHARES) - 1):
        low, high = (order + (layer + k) * count for k in range(2))
        for one in (
            np.column_stack([low, high[:, 2]]),
            np.column_stack([low[:, 0], low[:, 1], high[:, [2, 1]]]),
            np.column_stack([low[:, 0], high[:, [1, 2, 0]]]),
        ):
            one[turned] = one[turned][:, [0, 2, 1, 3]]
            found.append(one)
    return np.concatenate(found)
