"""Weights of smooth modes near zero, and alike on both sides (rig/modes.py).

r = m_k for each mode, and (m_k − m_mirror(k)) / σ for each pair.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import ConstantJacobian, Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.model import Rig
from breastrig.rig.modes import with_modes
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class Modes(StructuredTerm[BodyState]):
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

    @cached_property
    def _slope(self) -> ConstantJacobian:
        """(M, P)"""
        matrix = self._matrix
        others = np.zeros((len(matrix), BONE_DOFS * len(self.rig.bones) + len(self.rig.shapes)))
        return ConstantJacobian(np.concatenate([others, matrix], axis=1))

    def residual(self, state: BodyState) -> Array:
        """(M,)"""
        return np.asarray(self._matrix @ state.x.modes)

    def linearise(self, state: BodyState) -> Linearisation:
        """(M,), (M, P)"""
        return Linearisation(self.residual(state), self._slope.jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|²; JᵀJ is formed once."""
        return self._slope.normal_equations(self.residual(state))
