"""JᵀJ and Jᵀr of rows dᵀ ∂M_i/∂x by structure: what `Posed.rows` would give, without the zeros.

A vertex b of the shaped template is carried to Σ_j w_j (A_j b + t_j) (equation 3).  In the twelve entries of a bone's
affine map a row is w_j z with the same z = d ⊗ (b, 1) for all bones, and in the shape weights Aᵀd · b_k.  The way from
the nine steps of a bone to its affine map is the same for all vertices:

    ∂/∂(ω_j, T_j, s_j) = w_j zᵀ G_j,    G_j = ∂(A_j, t_j)/∂(ω_j, T_j, s_j)  (12 x 9)

So rows are one small product each, formed and multiplied group by group of vertices with the same bones and shapes
(vertex_groups.py), with the residual as one more column.

How much a vertex moves when the unknowns scatter, tr(J_i C J_iᵀ), has the same structure: for an axis e_a the part of a
row in bone j is w_j (e_a ⊗ (b, 1))ᵀ G_j, so the sum over the axes needs no more than the 4 x 4 blocks Σ_a (G_j C G_lᵀ)
at a; likewise for the shapes, and between both.
"""

import numpy as np
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.rotations import hat
from breastrig.least_squares.problem import NormalEquations
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.skinning import Posed, PosedWithCorrectives
from breastrig.rig.vertex_groups import VertexGroups, vertex_groups

AFFINE = 12  # entries of a bone's affine map: each row of A, then its entry of t
TURNS = hat(np.eye(3))  # (3, 3, 3): ∂exp(ω)/∂ω_m at 0


def normal_equations(posed: Posed, chosen: Integers, directions: Array, residual: Array) -> NormalEquations:
    """Normal equations of M residuals (M,) with the Jacobian directionsᵀ ∂M/∂x of the chosen vertices.

    directions: (M, 3), one for each of the (M,) chosen.
    """
    if isinstance(posed, PosedWithCorrectives):
        inner, step = normal_equations(posed.plain, chosen, directions, residual), posed.tangent
        hessian = step.T @ inner.hessian @ step
        return NormalEquations(0.5 * (hessian + hessian.T), step.T @ inner.gradient, inner.energy)
    if posed.rig.skinning != "linear":
        slopes = posed.rows(chosen, directions)
        return NormalEquations(slopes.T @ slopes, slopes.T @ residual, 0.5 * float(residual @ residual))
    size, grouped = posed.x.dof + 1, vertex_groups(posed.rig)
    of_row = grouped.of_vertex[chosen]
    order = np.argsort(of_row, kind="stable")
    chosen, directions, residual = chosen[order], directions[order], residual[order]
    z = _affine_columns(posed.shaped[chosen], directions)
    places, to_affine = grouped.places[chosen], affine_steps(posed)
    weights, shapes = grouped.weights[:, places], shape_rows(posed.linear[chosen], directions, places, grouped)
    ends = np.cumsum(np.bincount(of_row, minlength=len(grouped.groups))).tolist()
    entries, products, first = [], [], 0
    for group, last in zip(grouped.groups, ends, strict=True):
        if last > first:
            rows, bones = slice(first, last), len(group.bones)
            part = np.zeros((BONE_DOFS * bones + len(group.shapes) + 1, last - first))  # transposed: long inner loops
            steps = part[: BONE_DOFS * bones]
            np.matmul(to_affine[group.bones].reshape(-1, AFFINE), z[:, rows], out=steps)
            blocks = steps.reshape(bones, BONE_DOFS, -1)  # a view
            blocks *= weights[:bones, None, rows]
            part[BONE_DOFS * bones : -1] = shapes[rows, : len(group.shapes)].T
            part[-1] = residual[rows]
            entries.append(group.entries)
            products.append((part @ part.T).ravel())
        first = last
    table = np.zeros((size, size))
    if entries:
        table = _summed(np.concatenate(entries), np.concatenate(products), size * size).reshape(size, size)
    return NormalEquations(table[:-1, :-1].copy(), table[:-1, -1].copy(), 0.5 * float(table[-1, -1]))


def _summed(entries: Integers, values: Array, size: int) -> Array:
    """(size,): each value added to its entry."""
    return np.asarray(np.bincount(entries, values, size), dtype=np.float64)


def _affine_columns(places: Array, directions: Array) -> Array:
    """(12, M): d ⊗ (b, 1)."""
    result = np.ones((3, 4, len(places)))
    result[:, :3] = np.ascontiguousarray(places.T)
    result *= np.ascontiguousarray(directions.T)[:, None]
    return result.reshape(AFFINE, -1)


def shape_rows(linear: Array, directions: Array, places: Integers, grouped: VertexGroups) -> Array:
    """(M, max L): Aᵀd · b_k for the shapes of each row's group, as one sparse product; linear: (M, 3, 3)."""
    pulled = np.einsum("mij,mi->mj", linear, directions)
    columns = (3 * places[:, None] + np.arange(3)).ravel()
    starts = np.arange(0, len(columns) + 1, 3)
    return np.asarray(csr_array((pulled.ravel(), columns, starts), (len(places), len(grouped.shapes))) @ grouped.shapes)


def affine_steps(posed: Posed) -> Array:
    """(B, 9, 12): G_jᵀ of all bones."""
    rig, x = posed.rig, posed.x
    back = rig.rest_rotations.transpose(0, 2, 1)
    result = np.zeros((len(rig.bones), BONE_DOFS, 3, 4))
    linear = result[..., :3]  # of A_j = R_j S_j Q_jᵀ
    linear[:, 0:3] = (x.rotations[:, None] @ TURNS * x.scales[:, None, None, :]) @ back[:, None]
    linear[:, 6:9] = x.rotations.transpose(0, 2, 1)[:, :, :, None] * back[:, :, None, :]
    result[..., 3] = -np.einsum("bmij,bj->bmi", linear, rig.rest_origins)  # of t_j = T_j − A_j o_j
    result[:, 3:6, :, 3] = np.eye(3)
    return result.reshape(len(rig.bones), BONE_DOFS, AFFINE)


def vertex_variances(posed: Posed, covariance: Array) -> Array:
    """(V,) m², over all three axes, for a step with this (P, P) covariance."""
    if isinstance(posed, PosedWithCorrectives):
        return vertex_variances(posed.plain, posed.tangent @ covariance @ posed.tangent.T)
    if posed.rig.skinning != "linear":
        everyone = np.arange(len(posed.shaped))
        by_axis = (posed.rows(everyone, np.tile(axis, (len(everyone), 1))) for axis in np.eye(3))
        return np.asarray(sum(np.einsum("vp,vp->v", slopes @ covariance, slopes) for slopes in by_axis))
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
