"""The rig's tetrahedra in a fitted body.

Skin nodes are the fitted vertices, wall nodes lie under the skin without its breasts; the nodes between start on their
harmonic extension and are moved until every tetrahedron is well shaped (untangle.py). The same nodes and tetrahedra for
every body, and fast (docs/decisions/0021).
"""

from functools import lru_cache

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.half_edges import neighbours
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import bone_matrices
from breastrig.volume.known_volume import KnownVolume, known_volume
from breastrig.volume.untangle import untangle
from breastrig.volume.volume_mesh import SOFT, VolumeMesh

WALL_SPRING = 3.0  # the wall is an estimate,
SKIN_SPRING = 1000.0  # the skin is not


def volume_mesh(rig: Rig, x: RigParameters, vertices: Array) -> VolumeMesh:
    """The inside of a body: its pose and shapes, and its (V, 3) m skin, refined or not, in one frame.

    Raises BadInput for a rig whose inside is not known.
    """
    known = known_volume(rig)
    count = len(rig.template)
    points = nodes_between(rig, vertices, chest_wall(rig, x, vertices))
    loose = [members for name, members in known.attachments.items() if name.startswith("loose_")]
    sliding = count + np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *loose]))
    wall = count + np.arange(count)
    behind = np.unique(known.tetrahedra[known.regions >= SOFT])
    cuts = np.unique(known.cuts)
    return VolumeMesh(
        points=points,
        tetrahedra=known.tetrahedra,
        region=known.regions,
        surface=rig.faces,
        wall=rig.faces + count,
        model_vertex=np.where(np.arange(len(points)) < count, np.arange(len(points)), -1),
        fixed=np.setdiff1d(np.concatenate([wall, behind, cuts]), sliding),
        sliding=sliding,
        sets={"cuts": cuts} | {name: count + members for name, members in known.attachments.items()},
        depth=depths(rig),
        moved=float(np.linalg.norm(points[:count] - vertices, axis=1).max()),
    )


def nodes_between(rig: Rig, vertices: Array, wall: Array) -> Array:
    """(N, 3) m: all nodes of a body of (V, 3) m skin and wall, moved where tetrahedra are bad."""
    known = known_volume(rig)
    count = len(rig.template)
    start = extended(known, np.concatenate([vertices, wall]))
    springs = np.zeros(len(start))
    springs[known.cuts] = np.inf
    springs[count : 2 * count] = WALL_SPRING
    springs[:count] = SKIN_SPRING
    normals = np.zeros_like(start)
    normals[:count], normals[count : 2 * count] = (rig.normals_at(start[part : part + count]) for part in (0, count))
    return untangle(start, known.tetrahedra, known.points, springs, normals)


def chest_wall(rig: Rig, x: RigParameters, vertices: Array) -> Array:
    """(V, 3) m: the wall's point under each vertex of a body of this pose and (V, 3) m skin.

    The skin without the breasts, moved inwards as far as at rest.
    """
    known = known_volume(rig)
    rest = known.chest.of(rig.template)
    inwards = known.points[len(rest) : 2 * len(rest)] - rest
    linear = (rig.skin_weights @ bone_matrices(rig, x)[0].reshape(-1, 9)).reshape(-1, 3, 3)
    turned = np.einsum("vij,vj->vi", linear, inwards)
    turned *= np.linalg.norm(inwards, axis=1, keepdims=True) / np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(known.chest.of(vertices) + turned)


@lru_cache(maxsize=4)
def depths(rig: Rig) -> Array:
    """(N,) harmonic, 0 on the skin, 1 on the wall and behind it."""
    known = known_volume(rig)
    count, total = len(rig.template), len(known.points)
    behind = np.unique(known.tetrahedra[known.regions >= SOFT])
    depth = np.zeros(total)
    depth[count : 2 * count] = depth[behind] = 1.0
    depth[:count] = 0.0
    free = np.setdiff1d(np.arange(2 * count, total), behind)
    _solve(depth, stiffness(known), free)
    return depth


def extended(known: KnownVolume, surfaces: Array) -> Array:
    """(N, 3) m: skin and wall (2 V, 3) m, the smoothest cuts between their rims, and harmonic what lies between."""
    total, given = len(known.points), np.arange(len(surfaces))
    cut = np.setdiff1d(known.cuts, given)
    points = np.concatenate([surfaces, np.zeros((total - len(surfaces), 3))])
    _solve(points, (sparse.diags_array(np.ones(total)) - neighbours(known.cuts, total)).tocsr(), cut)
    _solve(points, stiffness(known), np.setdiff1d(np.arange(len(surfaces), total), cut))
    return points


def _solve(points: Array, matrix: sparse.csr_array, free: Integers) -> None:
    """Solves the `free` points so that their rows of matrix @ points are zero, in place."""
    rows = matrix[free]
    held = np.setdiff1d(np.arange(len(points)), free)
    points[free] = splu(rows[:, free].tocsc()).solve(-(rows[:, held] @ points[held]))


@lru_cache(maxsize=4)
def stiffness(known: KnownVolume) -> sparse.csr_array:
    """(N, N) of linear elements at rest: ∫ ∇φ_i · ∇φ_j."""
    gradients, volumes = shape_gradients(known.points, known.tetrahedra)
    local = np.einsum("m,mai,mbi->mab", volumes, gradients, gradients)
    rows, columns = (np.repeat(known.tetrahedra, 4, axis=1), np.tile(known.tetrahedra, (1, 4)))
    shape = (len(known.points), len(known.points))
    return sparse.coo_array((local.ravel(), (rows.ravel(), columns.ravel())), shape).tocsr()


def shape_gradients(points: Array, tetrahedra: Integers) -> tuple[Array, Array]:
    """((M, 4, 3) 1/m gradients of the four shape functions, (M,) m³ volumes)."""
    corners = points[tetrahedra]
    edges = corners[:, 1:] - corners[:, :1]  # rows
    inverse = np.linalg.inv(edges).transpose(0, 2, 1)
    gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    return gradients, np.linalg.det(edges) / 6.0
