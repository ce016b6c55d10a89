"""A soft symmetry prior: a side that is not seen follows the other, and asymmetry stays possible.

r = (α_k − α_mirror(k))/σ for each pair of shapes and (s_j − s_mirror(j))/σ_s for each pair of bones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import ConstantTerm
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class Symmetry(ConstantTerm[BodyState]):
    rig: Rig
    shape_sigma: float  # expected left-right difference of a weight, in the shape's own sigmas
    scale_sigma: float  # expected left-right difference of a scale
    name: str = "symmetry"

    @cached_property
    def _pairs(self) -> tuple[list[tuple[int, int, float]], list[tuple[int, int]]]:
        rig = self.rig
        shape_index = {name: k for k, name in enumerate(rig.shape_names)}
        bone_index = {name: j for j, name in enumerate(rig.bone_names)}
        shapes = [(k, shape_index[s.mirror], s.sigma) for k, s in enumerate(rig.shapes) if k < shape_index[s.mirror]]
        bones = [(j, bone_index[b.mirror]) for j, b in enumerate(rig.bones) if j < bone_index[b.mirror]]
        return shapes, bones

    def residual(self, state: BodyState) -> Array:
        """(M,)"""
        shapes, bones = self._pairs
        weights = [(state.x.weights[a] - state.x.weights[b]) / (self.shape_sigma * sigma) for a, b, sigma in shapes]
        scales = [(state.x.scales[a] - state.x.scales[b]) / self.scale_sigma for a, b in bones]
        return np.concatenate([np.asarray(weights, dtype=np.float64), *scales])

    def slope(self) -> Array:
        """(M, P)"""
        shapes, bones = self._pairs
        first = BONE_DOFS * len(self.rig.bones)
        jacobian = np.zeros((len(shapes) + 3 * len(bones), first + len(self.rig.shapes)))
        for row, (a, b, sigma) in enumerate(shapes):
            jacobian[row, first + a] = 1.0 / (self.shape_sigma * sigma)
            jacobian[row, first + b] = -1.0 / (self.shape_sigma * sigma)
        for pair, (a, b) in enumerate(bones):
            for axis in range(3):
                row = len(shapes) + 3 * pair + axis
                jacobian[row, BONE_DOFS * a + 6 + axis] = 1.0 / self.scale_sigma
                jacobian[row, BONE_DOFS * b + 6 + axis] = -1.0 / self.scale_sigma
        return jacobian
