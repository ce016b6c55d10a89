"""Blendshape weights near zero (E_BS, equation 5, squared as a quadratic solver needs it).

r_k = α_k / σ_k; σ_k is the shape's expected size from the rig times the preset's factor.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.blocks import shape_block
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class ShapePrior(StructuredTerm[BodyState]):
    sigma: Array  # (S,) expected size of each weight
    centre: Array  # (S,) expected value of each weight (not zero for gravity shapes of a supine scan)
    name: str = "shape_prior"

    def residual(self, state: BodyState) -> Array:
        """(S,)"""
        return np.asarray((state.x.weights - self.centre) / self.sigma)

    def linearise(self, state: BodyState) -> Linearisation:
        """(S,), (S, P)"""
        jacobian = np.zeros((len(self.sigma), state.dof))
        jacobian[:, shape_block(state.rig)] = np.diag(1.0 / self.sigma)
        return Linearisation(self.residual(state), jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ (diagonal), Jᵀr, ½ |r|²."""
        residual, own = self.residual(state), shape_block(state.rig)
        hessian, gradient = np.zeros((state.dof, state.dof)), np.zeros(state.dof)
        hessian[own, own], gradient[own] = np.diag(self.sigma**-2), residual / self.sigma
        return NormalEquations(hessian, gradient, 0.5 * float(residual @ residual))
