"""Equation 3 of the paper: blendshapes, then linear blend skinning, and its derivative.

    M_i = Σ_j w_ij ( R_j S_j Q_jᵀ (B_i(α) − o_j) + T_j ),   B(α) = v + Σ_k α_k b_k     (2)

`Posed` keeps what posing computes, because the Jacobian needs the same pieces.  The Jacobian is never
formed as (3V, P): a term asks for rows dᵀ ∂M_i/∂x with its own direction d per vertex (a plane's normal, an
axis), and each row is assembled from the structure.  With u = Q_jᵀ(B − o_j), p = S_j u, e = R_jᵀ d and
A_i = Σ_j w_ij R_j S_j Q_jᵀ:

    ∂/∂ω_j = w_ij p × e     ∂/∂T_j = w_ij d     ∂/∂s_j = w_ij e ∘ u     ∂/∂α_k = (A_iᵀ d) · b_ik
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


def shaped(rig: Rig, weights: Array) -> Array:
    """(V, 3) m: equation 2, the template with its blendshapes, unposed."""
    return np.asarray(
        rig.template + (weights @ rig.blendshapes.reshape(len(weights), rig.template.size)).reshape(-1, 3)
    )


def bone_matrices(rig: Rig, x: RigParameters) -> tuple[Array, Array]:
    """((B, 3, 3), (B, 3) m): the affine map of each bone, b -> A_j b + t_j."""
    linear = (x.rotations * x.scales[:, None, :]) @ rig.rest_rotations.transpose(0, 2, 1)
    return linear, x.translations - np.einsum("bij,bj->bi", linear, rig.rest_origins)


@dataclass(frozen=True, eq=False)
class Posed:
    """A rig in one pose, with the pieces its derivative shares."""

    rig: Rig
    x: RigParameters

    @cached_property
    def shaped(self) -> Array:
        """(V, 3) m, unposed."""
        return shaped(self.rig, self.x.weights)

    @cached_property
    def _blended(self) -> Array:
        """(V, 12): the blended affine map of each vertex, row-major linear part then offset."""
        linear, offset = bone_matrices(self.rig, self.x)
        return np.asarray(self.rig.skin_weights @ np.concatenate([linear.reshape(-1, 9), offset], axis=1))

    @cached_property
    def linear(self) -> Array:
        """(V, 3, 3): A_i, the blended linear map of each vertex."""
        return self._blended[:, :9].reshape(-1, 3, 3)

    @cached_property
    def vertices(self) -> Array:
        """(V, 3) m: equation 3."""
        return np.asarray(np.einsum("vij,vj->vi", self.linear, self.shaped) + self._blended[:, 9:])

    def rows(self, chosen: Integers, directions: Array) -> Array:
        """(M, P): directionsᵀ ∂M/∂x for M chosen vertices with one direction (M, 3) each.

        Laid out by columns (Fortran order): each block is then written along M contiguous numbers instead of 9.
        """
        rig, x = self.rig, self.x
        bones, count = len(rig.bones), len(chosen)
        columns = np.zeros((x.dof, count))
        # (3, B, M): local axis, bone, vertex
        axes, origins = rig.rest_axes
        u = (axes @ self.shaped[chosen].T - origins).reshape(3, bones, count)
        p = u * x.scales.T[:, :, None]
        weight = rig.weights_by_bone[:, chosen]
        we = (x.rotations.transpose(2, 0, 1).reshape(-1, 3) @ directions.T).reshape(3, bones, count)
        we *= weight
        blocks = columns[: BONE_DOFS * bones].reshape(bones, BONE_DOFS, count)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            np.multiply(p[j], we[k], out=blocks[:, i])
            blocks[:, i] -= p[k] * we[j]
            np.multiply(weight, directions[:, i], out=blocks[:, 3 + i])
            np.multiply(we[i], u[i], out=blocks[:, 6 + i])
        pulled = np.einsum("mij,mi->mj", self.linear[chosen], directions)  # A_iᵀ d
        columns[BONE_DOFS * bones :] = np.matmul(pulled[:, None, :], rig.shapes_by_vertex[chosen])[:, 0].T
        return columns.T


def pose(rig: Rig, x: RigParameters) -> Array:
    """(V, 3) m: equation 3."""
    return Posed(rig, x).vertices
