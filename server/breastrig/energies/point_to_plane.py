"""Distance of matched model vertices to the tangent plane of their scan point (E_D, equation 7).

r_m = √w_m n_m · (M_m(x) − p_m) / σ.  The paper takes the residual's direction from the scan's normal
(section 2.6); sliding along the surface is free, so it converges in few steps near the solution
(Chen and Medioni 1991), and `point_to_point` adds the hold that it lacks far away.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import Correspondences
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.model import Rig
from breastrig.rig.normal_equations import normal_equations
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class PointToPlane(StructuredTerm[BodyState]):
    rig: Rig
    matches: Correspondences
    weights: Array  # (M,) robust weight of each match
    sigma: float  # m, expected distance of a well fitted model
    name: str = "point_to_plane"

    def residual(self, state: BodyState) -> Array:
        """(M,)"""
        gap = state.posed.vertices[self.matches.vertices] - self.matches.points
        return np.asarray(np.einsum("mi,mi->m", self._directions, gap))

    @cached_property
    def _directions(self) -> Array:
        """(M, 3)"""
        return np.asarray(self.matches.normals * (np.sqrt(self.weights) / self.sigma)[:, None])

    def linearise(self, state: BodyState) -> Linearisation:
        """(M,), (M, P)"""
        return Linearisation(self.residual(state), state.posed.rows(self.matches.vertices, self._directions))

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|² by structure, without the Jacobian."""
        return normal_equations(state.posed, self.matches.vertices, self._directions, self.residual(state))
