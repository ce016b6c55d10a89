"""Applies skin and morph targets of a glTF scene to a mesh: in the pose of its nodes, without animations.

glTF ignores the transform of a node that has a skin: its joints place the mesh, each with its inverse bind matrix.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.gltf_arrays import whole


def joint_matrices(skin: dict[str, Any], world: dict[int, Array], inverse_binds: NDArray[Any] | None) -> Array:
    """(J, 4, 4) from the mesh to the scene; `world` has the (4, 4) matrix of each node.

    ValueError where a joint is in no scene.
    """
    joints = [whole(joint, "a joint's number") for joint in skin["joints"]]
    if any(joint not in world for joint in joints) or not joints:
        raise ValueError("a joint of it is in no scene")
    placed = np.stack([world[joint] for joint in joints])
    if inverse_binds is None:
        return placed
    if len(inverse_binds) < len(joints):
        raise ValueError("joints of it have no inverse bind matrix")
    return np.asarray(placed @ inverse_binds[: len(joints)])


def skinned(vertices: Array, joints: Integers, weights: Array, matrices: Array) -> tuple[Array, bool]:
    """((V, 3) vertices where (V, k) joints with these weights put them, whether they are mirrored there)."""
    if joints.shape != weights.shape or len(joints) != len(vertices):
        raise ValueError("its joints and weights are not those of its vertices")
    if joints.max(initial=0) >= len(matrices):
        raise ValueError("its vertices name joints that do not exist")
    total = weights.sum(axis=1)
    shares = np.divide(weights, total[:, None], out=np.zeros_like(weights), where=total[:, None] != 0.0)
    shares[total == 0.0, 0] = 1.0
    moved = np.zeros_like(vertices)
    for joint, share in zip(joints.T, shares.T, strict=True):
        of_joint = matrices[joint]
        moved += share[:, None] * (np.einsum("vij,vj->vi", of_joint[:, :3, :3], vertices) + of_joint[:, :3, 3])
    strongest = matrices[np.unique(joints[np.arange(len(joints)), shares.argmax(axis=1)])]
    return moved, bool((np.linalg.det(strongest[:, :3, :3]) < 0.0).all())
