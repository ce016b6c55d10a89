"""Equation 3 of the paper: blendshapes, then linear blend skinning.

M_i = Σ_j w_ij ( R_j S_j Q_jᵀ (B_i(α) − o_j) + T_j ),   B(α) = v + Σ_k α_k b_k     (2)
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters


def shaped(rig: Rig, weights: Array) -> Array:
    """(V, 3) m: equation 2, the template with its blendshapes, unposed."""
    return np.asarray(rig.template + np.tensordot(weights, rig.blendshapes, axes=1))


def bone_matrices(rig: Rig, x: RigParameters) -> tuple[Array, Array]:
    """((B, 3, 3), (B, 3) m): the affine map of each bone, b -> A_j b + t_j."""
    rest = np.array([bone.rotation for bone in rig.bones])
    origins = np.array([bone.origin for bone in rig.bones])
    linear = (x.rotations * x.scales[:, None, :]) @ rest.transpose(0, 2, 1)
    return linear, x.translations - np.einsum("bij,bj->bi", linear, origins)


def pose(rig: Rig, x: RigParameters) -> Array:
    """(V, 3) m: equation 3."""
    linear, offset = bone_matrices(rig, x)
    bones = len(rig.bones)
    blended = rig.skin_weights @ np.concatenate([linear.reshape(bones, 9), offset], axis=1)  # (V, 12)
    points = shaped(rig, x.weights)
    return np.asarray(np.einsum("vij,vj->vi", blended[:, :9].reshape(-1, 3, 3), points) + blended[:, 9:])
