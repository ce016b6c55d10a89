"""Blendshape weights near zero (E_BS, equation 5, squared as a quadratic solver needs it).

r_k = α_k / σ_k; σ_k is the shape's expected size from the rig times the preset's factor.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True, eq=False)
class ShapePrior:
    sigma: Array  # (S,) expected size of each weight
    centre: Array  # (S,) expected value of each weight (not zero for gravity shapes of a supine scan)
    name: str = "shape_prior"

    def residual(self, x: RigParameters) -> Array:
        """(S,)"""
        return np.asarray((x.weights - self.centre) / self.sigma)

    def linearise(self, x: RigParameters) -> Linearisation:
        """(S,), (S, P)"""
        shapes = len(x.weights)
        jacobian = np.zeros((shapes, x.dof))
        jacobian[:, x.dof - shapes :] = np.diag(1.0 / self.sigma)
        return Linearisation(self.residual(x), jacobian)
