"""One state of the model during a fit: its parameters, and what posing and joints make of them, computed once.

All terms of an iteration look at the same state, so each needs neither to pose the model anew nor to know who has.
"""

from dataclasses import dataclass, field
from functools import cached_property

from breastrig.core.arrays import Array
from breastrig.rig.joints import JointMotion, Joints
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import Posed, in_pose


@dataclass(frozen=True, eq=False)
class BodyState:
    """A point on the manifold of one posed and shaped rig."""

    rig: Rig
    x: RigParameters
    _motions: dict[Joints, JointMotion] = field(default_factory=dict, init=False, repr=False)

    @property
    def dof(self) -> int:
        """P, the length of a tangent step."""
        return self.x.dof

    def retract(self, step: Array) -> "BodyState":
        """The state reached along the (P,) tangent `step`."""
        return BodyState(self.rig, self.x.retract(step))

    @cached_property
    def posed(self) -> Posed:
        """The surface in this pose, with its derivative."""
        return in_pose(self.rig, self.x)

    @property
    def vertices(self) -> Array:
        """(V, 3) m: equation 3."""
        return self.posed.vertices

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit."""
        return self.rig.normals_at(self.vertices)

    @cached_property
    def chordal_deviation(self) -> Array:
        """(V,) m, by which the triangles around each vertex lie below the skin that the vertices are samples of."""
        return self.rig.chordal_deviation_at(self.vertices, self.normals)

    def motion(self, joints: Joints) -> JointMotion:
        """Gaps and turns at the joints, and their derivative."""
        if joints not in self._motions:
            self._motions[joints] = joints.motion(self.x)
        return self._motions[joints]
