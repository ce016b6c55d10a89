"""How much each vertex moves when the unknowns scatter: tr(J_i C J_iᵀ) with the structure of normal_equations.py.

For an axis e_a the part of a row in bone j is w_j (e_a ⊗ (b, 1))ᵀ G_j, so the sum over the axes needs no more than the
4 x 4 blocks Σ_a (G_j C G_lᵀ) at a; likewise for the shapes, and between both.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.rig.normal_equations import affine_steps, shape_rows
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.skinning import Posed
from breastrig.rig.vertex_groups import vertex_groups


def vertex_variances(posed: Posed, covariance: Array) -> Array:
    """(V,) m², over all three axes, for a step with this (P, P) covariance."""
    grouped = vertex_groups(posed.rig)
    order = np.argsort(grouped.places)  # group after group
    sizes = np.bincount(grouped.of_vertex, minlength=len(grouped.groups))
    places = np.ones((len(order), 1, 4))
    places[:, 0, :3] = posed.shaped[order]
    weighted = grouped.weights.T[:, :, None] * places  # (V, max K, 4)
    axes, each = np.tile(np.eye(3), (len(order), 1)), np.repeat(np.arange(len(order)), 3)
    moved = shape_rows(posed.linear[order][each], axes, each, grouped).reshape(len(order), 3, -1)  # (V, 3, max L)
    steps, shapes = _affine(covariance, posed)
    result, first = np.zeros(len(order)), 0
    for group, size in zip(grouped.groups, sizes.tolist(), strict=True):
        rows, bones = slice(first, first + size), group.bones
        y = weighted[rows, : len(bones)].reshape(size, -1)  # (N, 4 K)
        own = steps[bones][:, bones].transpose(0, 2, 1, 3).reshape(y.shape[1], y.shape[1])
        result[order[rows]] = np.einsum("nk,nk->n", y @ own, y)
        own_shapes = BONE_DOFS * len(posed.rig.bones) + group.shapes
        within = covariance[own_shapes[:, None], own_shapes]
        for axis in range(3):
            s = moved[rows, axis, : len(group.shapes)]
            across = shapes[axis][bones][:, :, group.shapes].reshape(y.shape[1], -1)
            result[order[rows]] += np.einsum("nl,nl->n", s @ within + 2.0 * (y @ across), s)
        first += size
    return result


def _affine(covariance: Array, posed: Posed) -> tuple[Array, Array]:
    """((B, B, 4, 4), (3, B, 4, S)): the blocks of bones, summed over the axes, and those of bones and shapes."""
    bones = len(posed.rig.bones)
    down = affine_steps(posed).transpose(0, 2, 1)  # (B, 12, 9)
    left = (down @ covariance[: BONE_DOFS * bones].reshape(bones, BONE_DOFS, -1)).reshape(bones, 3, 4, -1)
    mixed = left[..., : BONE_DOFS * bones].reshape(bones, 3, 4, bones, BONE_DOFS)
    steps = np.einsum(
        "jacld,ladk->jlck", mixed, down.reshape(bones, 3, 4, BONE_DOFS).transpose(0, 1, 3, 2), optimize=True
    )
    return steps, np.ascontiguousarray(left[..., BONE_DOFS * bones :].transpose(1, 0, 2, 3))
