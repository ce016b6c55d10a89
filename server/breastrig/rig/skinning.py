"""Equation 3 of the paper: blendshapes, then skinning, linear, by dual quaternions or corrected; and its derivative.

    M_i = Σ_j w_ij ( R_j S_j Q_jᵀ (B_i(α) − o_j) + T_j ),   B(α) = v + Σ_k α_k b_k     (2)

`Posed` keeps what posing computes, because the Jacobian needs the same pieces.  The Jacobian is never
formed as (3V, P): a term asks for rows dᵀ ∂M_i/∂x with its own direction d per vertex (a plane's normal, an
axis), and each row is assembled from the structure.  With u = Q_jᵀ(B − o_j), p = S_j u, e = R_jᵀ d and
A_i = Σ_j w_ij R_j S_j Q_jᵀ:

    ∂/∂ω_j = w_ij p × e     ∂/∂T_j = w_ij d     ∂/∂s_j = w_ij e ∘ u     ∂/∂α_k = (A_iᵀ d) · b_ik

Dual quaternions (Kavan, Collins, Žára and O'Sullivan, ACM Transactions on Graphics 27, 2008) blend rigid motions alone.
So a body is stretched first, at rest, which is linear skinning with R_j = Q_j and T_j = o_j, and then moved (two
layers, as there): with c = Σ_j w_ij (r_j, e_j), r_j the rotation R_j Q_jᵀ and e_j = (T_j r_j − r_j o_j) / 2,

    M_i = (r x r* + 2 e r*) / |r|²      ∂(d · M_i)/∂e = 2 d r / |r|²      ∂/∂r = −2 (d (r x + e) + (d · M_i) r) / |r|²

Corrected (pose space deformation: Lewis, Cordner and Fong, SIGGRAPH 2000): linear skinning with further blendshapes
whose weights c_k(φ) are polynomials of joints' turns φ (joints.py); their columns are those of shapes, times ∂c_k/∂x.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.rotations import quaternion_from_rotation, quaternion_product, rotation_from_quaternion
from breastrig.rig.joints import Joints
from breastrig.rig.model import Rig, Skinning
from breastrig.rig.modes import with_modes
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
    """A rig in one pose by linear skinning, as glTF has it, with the pieces its derivative shares."""

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


class PosedByDualQuaternions(Posed):
    """A rig posed by dual quaternions; symbols as in the comments at the head of this module."""

    @cached_property
    def _stretched(self) -> Posed:
        """The first layer: every bone at rest but for its scale."""
        rest = RigParameters(self.rig.rest_rotations, self.rig.rest_origins, self.x.scales, self.x.weights)
        return Posed(self.rig, rest)

    @cached_property
    def _turns(self) -> Array:
        """(B, 4): r_j."""
        return quaternion_from_rotation(self.x.rotations @ self.rig.rest_rotations.transpose(0, 2, 1))

    @cached_property
    def _weights(self) -> Array:
        """(V, B): skin weights, negative where a bone's quaternion is on the far side of the vertex's main bone's."""
        alike = self._turns @ self._turns.T
        return np.asarray(self.rig.skin_weights * np.where(alike < 0.0, -1.0, 1.0)[self.rig.main_bones])

    @cached_property
    def _blended(self) -> Array:
        """(V, 8): r and e, divided by |r|."""
        turns = self._turns
        away = quaternion_product(self.x.translations, turns) - quaternion_product(turns, self.rig.rest_origins)
        both = self._weights @ np.concatenate([turns, 0.5 * away], axis=1)
        return np.asarray(both / self._lengths(both))

    @staticmethod
    def _lengths(both: Array) -> Array:
        return np.asarray(np.linalg.norm(both[:, :4], axis=1, keepdims=True))

    @cached_property
    def _turned(self) -> Array:
        """(V, 3, 3) rotations of the second layer."""
        return rotation_from_quaternion(self._blended[:, :4])

    @cached_property
    def linear(self) -> Array:
        return np.asarray(self._turned @ self._stretched.linear)

    @cached_property
    def vertices(self) -> Array:
        r, e = self._blended[:, :4], self._blended[:, 4:]
        moved = quaternion_product(2.0 * e, r * [-1.0, -1.0, -1.0, 1.0])[:, :3]
        return np.asarray(np.einsum("vij,vj->vi", self._turned, self._stretched.vertices) + moved)

    def rows(self, chosen: Integers, directions: Array) -> Array:
        rig, x = self.rig, self.x
        bones, count = len(rig.bones), len(chosen)
        result = self._stretched.rows(chosen, np.einsum("mij,mi->mj", self._turned[chosen], directions))
        r, e = self._blended[chosen, :4], self._blended[chosen, 4:]
        along = np.einsum("mi,mi->m", directions, self.vertices[chosen])[:, None]
        inside = quaternion_product(r, self._stretched.vertices[chosen]) + e
        slopes = 2.0 * np.concatenate(
            [-quaternion_product(directions, inside) - along * r, quaternion_product(directions, r)], axis=1
        )
        turns, weights = self._turns, self._weights
        slopes /= self._lengths(weights[chosen] @ turns)
        spins = 0.5 * quaternion_product(turns[:, None], rig.rest_rotations.transpose(0, 2, 1))  # (B, 3, 4): ∂r_j/∂ω_j
        swung = quaternion_product(x.translations[:, None], spins) - quaternion_product(
            spins, rig.rest_origins[:, None]
        )
        steps = np.zeros((bones, 6, 8))
        steps[:, :3] = np.concatenate([spins, 0.5 * swung], axis=2)
        steps[:, 3:, 4:] = 0.5 * quaternion_product(np.eye(3), turns[:, None])
        blocks = result[:, : BONE_DOFS * bones].reshape(count, bones, BONE_DOFS)
        blocks[:, :, :6] = np.einsum("mb,bkq,mq->mbk", weights[chosen], steps, slopes, optimize=True)
        result[:, : BONE_DOFS * bones] = blocks.reshape(count, -1)
        return result


def as_linear(rig: Rig, x: RigParameters) -> tuple[Rig, RigParameters]:
    """The rig and parameters with correctives as shapes of their own, as in glTF; linear rigs are unchanged."""
    if not rig.correctives:
        return rig, x
    weights = np.concatenate([x.weights, _correction(rig, x)[0]])
    return rig.with_correctives_as_shapes, RigParameters(x.rotations, x.translations, x.scales, weights)


def _correction(rig: Rig, x: RigParameters) -> tuple[Array, Array]:
    """((K,) weights of the correctives, (K, P) their derivative)."""
    motion = Joints(rig, tuple(rig.joints[each.joint] for each in rig.correctives)).motion(x)
    powers = np.array([each.powers for each in rig.correctives])
    factors = motion.turn**powers
    slopes = powers * motion.turn ** np.maximum(powers - 1, 0)
    by_turn = np.stack([slopes[:, i] * np.delete(factors, i, axis=1).prod(axis=1) for i in range(3)], axis=1)
    return factors.prod(axis=1), np.einsum("ki,kip->kp", by_turn, motion.jacobian[:, 3:])


class PosedWithCorrectives(Posed):
    """A rig posed with correctives."""

    @cached_property
    def plain(self) -> Posed:
        """The pose with the correctives as shapes of their own."""
        return Posed(*as_linear(self.rig, self.x))

    @cached_property
    def tangent(self) -> Array:
        """(P + K, P): the derivative of a step of `plain` by a step of this."""
        return np.concatenate([np.eye(self.x.dof), _correction(self.rig, self.x)[1]])

    @cached_property
    def shaped(self) -> Array:
        return self.plain.shaped

    def rows(self, chosen: Integers, directions: Array) -> Array:
        every = self.plain.rows(chosen, directions)
        own = self.x.dof
        return np.asarray(every[:, :own] + every[:, own:] @ self.tangent[own:])


POSED: dict[Skinning, type[Posed]] = {
    "linear": Posed,
    "dual_quaternion": PosedByDualQuaternions,
    "corrective": PosedWithCorrectives,
}


def in_pose(rig: Rig, x: RigParameters) -> Posed:
    """The rig posed by the skinning that it names; modes are further shapes."""
    if len(x.modes):
        rig, x = with_modes(rig), replace(x, weights=np.concatenate([x.weights, x.modes]), modes=x.modes[:0])
    return POSED[rig.skinning](rig, x)


def pose(rig: Rig, x: RigParameters) -> Array:
    """(V, 3) m: equation 3."""
    return in_pose(rig, x).vertices
