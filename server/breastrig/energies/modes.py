"""Weights of smooth modes near zero, and alike on both sides (rig/modes.py).

r = m_k for each mode, and (m_k − m_mirror(k)) / σ for each pair.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import ConstantTerm
from breastrig.rig.model import Rig
from breastrig.rig.modes import with_modes
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class Modes(ConstantTerm[BodyState]):
    rig: Rig
    symmetry_sigma: float  # expected left-right difference, of one deviation
    name: str = "modes"

    @cached_property
    def _matrix(self) -> Array:
        """(M, K)"""
        shapes = with_modes(self.rig).shapes[len(self.rig.shapes) :]
        index = {shape.name: k for k, shape in enumerate(shapes)}
        pairs = [(k, index[shape.mirror]) for k, shape in enumerate(shapes) if k < index[shape.mirror]]
        eye = np.eye(len(shapes))
        return np.concatenate([eye, *((eye[[a]] - eye[[b]]) / self.symmetry_sigma for a, b in pairs)])

    def slope(self) -> Array:
        """(M, P)"""
        matrix = self._matrix
        others = np.zeros((len(matrix), BONE_DOFS * len(self.rig.bones) + len(self.rig.shapes)))
        return np.concatenate([others, matrix], axis=1)

    def residual(self, state: BodyState) -> Array:
        """(M,)"""
        return np.asarray(self._matrix @ state.x.modes)
