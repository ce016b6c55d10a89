"""Relative motion at the joints: how far two linked bones have come apart and turned against each other.

With G_j = R_j Q_jᵀ the rotation of bone j from rest and X_j(a) the place to which bone j (rotated, scaled, moved)
carries the joint's anchor a:

    gap  = G_pᵀ (X_c(a) − X_p(a))       in the parent's axes (m)
    turn = log(G*ᵀ G_pᵀ G_c)            beyond the joint's rest rotation G* (rad)

Both sides of the anchor move with the bones' scales, as the paper's section 2.2 asks ("a rigid point attached to
the scalable bones").  The derivatives are for a step of rig/parameters.py.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.rotations import exp_so3, hat, log_so3, right_jacobian_inverse
from breastrig.rig.model import Joint, Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


@dataclass(frozen=True, eq=False)
class Joints:
    """J joints of one rig."""

    rig: Rig
    joints: tuple[Joint, ...]
    rest: Array | None = None  # (J, 3) rad, G* as rotation vectors; None: the pose in which the rig was built

    @cached_property
    def arms(self) -> tuple[Integers, Integers, Array, Array, Array, Array]:
        """(J,) parents and children, (J, 3, 3) their rest axes, (J, 3) m the anchor in each one's own axes."""
        rig = self.rig
        p, c = (np.array([getattr(j, end) for j in self.joints], dtype=np.int64) for end in ("parent", "child"))
        anchors = np.array([j.anchor for j in self.joints]).reshape(-1, 3)
        q_p, q_c = rig.rest_rotations[p], rig.rest_rotations[c]
        u_p = np.einsum("jab,ja->jb", q_p, anchors - rig.rest_origins[p])
        u_c = np.einsum("jab,ja->jb", q_c, anchors - rig.rest_origins[c])
        return p, c, q_p, q_c, u_p, u_c

    def motion(self, x: RigParameters) -> "JointMotion":
        """Gaps and turns at x."""
        return JointMotion(self, x)


@dataclass(frozen=True, eq=False)
class JointMotion:
    """The motion at J joints of a rig with parameters x; computed on first use, and cached."""

    joints: Joints
    x: RigParameters

    @cached_property
    def _into_parent(self) -> Array:
        """(J, 3, 3) world axes to the parent's rest axes."""
        p, _, q_p, _, _, _ = self.joints.arms
        return np.asarray(q_p @ self.x.rotations[p].transpose(0, 2, 1))

    @cached_property
    def _world_gap(self) -> Array:
        """(J, 3) m, in world axes."""
        x = self.x
        p, c, _, _, u_p, u_c = self.joints.arms
        at_p = np.einsum("jab,jb->ja", x.rotations[p], x.scales[p] * u_p) + x.translations[p]
        at_c = np.einsum("jab,jb->ja", x.rotations[c], x.scales[c] * u_c) + x.translations[c]
        return np.asarray(at_c - at_p)

    @cached_property
    def gap(self) -> Array:
        """(J, 3) m, in the parent's rest axes."""
        return np.asarray(np.einsum("jab,jb->ja", self._into_parent, self._world_gap))

    @cached_property
    def turn(self) -> Array:
        """(J, 3) rad, rotation vectors beyond the rest."""
        _, c, _, q_c, _, _ = self.joints.arms
        relative = self._into_parent @ self.x.rotations[c] @ q_c.transpose(0, 2, 1)
        if self.joints.rest is not None:
            relative = exp_so3(self.joints.rest).transpose(0, 2, 1) @ relative
        return log_so3(relative)

    @cached_property
    def jacobian(self) -> Array:
        """(J, 6, P), read-only: the derivatives of each joint's gap (first three rows) and turn."""
        x, into_parent = self.x, self._into_parent
        p, c, q_p, q_c, u_p, u_c = self.joints.arms
        r_p, r_c = x.rotations[p], x.rotations[c]
        inverse = right_jacobian_inverse(self.turn)
        local_gap = np.einsum("jba,jb->ja", r_p, self._world_gap)
        parent, child = np.zeros((2, len(p), 6, BONE_DOFS))
        parent[:, :3, 0:3] = q_p @ (hat(local_gap) + hat(x.scales[p] * u_p))
        parent[:, :3, 3:6] = -into_parent
        parent[:, :3, 6:9] = -q_p * u_p[:, None, :]
        child[:, :3, 0:3] = -into_parent @ r_c @ hat(x.scales[c] * u_c)
        child[:, :3, 3:6] = into_parent
        child[:, :3, 6:9] = (into_parent @ r_c) * u_c[:, None, :]
        child[:, 3:, 0:3] = inverse @ q_c
        parent[:, 3:, 0:3] = -inverse @ q_c @ r_c.transpose(0, 2, 1) @ r_p
        result = np.zeros((len(p), 6, x.dof))
        blocks = result[:, :, : BONE_DOFS * len(x.scales)].reshape(len(p), 6, -1, BONE_DOFS)
        rows = np.arange(len(p))
        blocks[rows, :, p], blocks[rows, :, c] = parent, child
        result.flags.writeable = False
        return result
