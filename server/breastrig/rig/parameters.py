"""The unknowns of a fit: a point on a manifold, moved by `retract`.

Maximal coordinates as in the paper (section 2.2): every bone has its own absolute rotation, translation and
scale (nine degrees of freedom), and joints hold the bones together by constraints.  A tangent step has
P = 9 B + S + K entries: for each bone [rotation vector (3, rad, in the bone's own axes: R <- R exp), translation
(3, m), scale (3)], then the S shape weights, then those of the K modes (modes.py), where a fit has come to them.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, frozen
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig

BONE_DOFS = 9
FIELDS = ("rotations", "translations", "scales", "weights", "modes")


@dataclass(frozen=True, eq=False)
class RigParameters:
    """One posed and shaped rig."""

    rotations: Array  # (B, 3, 3) absolute rotation of each bone
    translations: Array  # (B, 3) m, position of each bone's origin
    scales: Array  # (B, 3) per local axis
    weights: Array  # (S,) blendshape weights
    modes: Array = field(default_factory=lambda: np.zeros(0))  # (K,) weights of smooth modes, or (0,): none

    def __post_init__(self) -> None:
        for name in FIELDS:
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @staticmethod
    def of_numbers(numbers: dict[str, Any]) -> "RigParameters":
        """The parameters that `numbers` returned, to the last bit."""
        return RigParameters(**{name: np.array(numbers[name]) for name in FIELDS})

    def numbers(self) -> dict[str, Any]:
        """Plain lists, ready for JSON."""
        return {name: getattr(self, name).tolist() for name in FIELDS}

    @property
    def dof(self) -> int:
        """P, the length of a tangent step."""
        return BONE_DOFS * len(self.rotations) + len(self.weights) + len(self.modes)

    def retract(self, step: Array) -> "RigParameters":
        """The point reached along the (P,) tangent `step`."""
        bones = len(self.rotations)
        moves = step[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)
        return RigParameters(
            rotations=self.rotations @ exp_so3(moves[:, 0:3]),
            translations=self.translations + moves[:, 3:6],
            scales=self.scales + moves[:, 6:9],
            weights=self.weights + step[BONE_DOFS * bones :][: len(self.weights)],
            modes=self.modes + step[BONE_DOFS * bones + len(self.weights) :],
        )

    @property
    def without_modes(self) -> "RigParameters":
        """What files have: bones and shapes; modes are in their skin layer."""
        return replace(self, modes=self.modes[:0])

    def moved(self, rotation: Array, translation: Array) -> "RigParameters":
        """The whole rig moved rigidly: x -> rotation x + translation (m)."""
        return RigParameters(
            rotations=rotation @ self.rotations,
            translations=self.translations @ rotation.T + translation,
            scales=self.scales,
            weights=self.weights,
            modes=self.modes,
        )


def rest_parameters(rig: Rig) -> RigParameters:
    """The rig as it was built: identity skinning, no shapes."""
    return RigParameters(
        rotations=np.array([bone.rotation for bone in rig.bones]),
        translations=np.array([bone.origin for bone in rig.bones]),
        scales=np.ones((len(rig.bones), 3)),
        weights=np.zeros(len(rig.shapes)),
    )
