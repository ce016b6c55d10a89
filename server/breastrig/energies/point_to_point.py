"""Distance of matched model vertices to their scan point, all three axes (E_D, equation 7, as printed).

r_m = √w_m (M_m(x) − p_m) / σ.  Holds the model along the surface too, which helps while it is far away and
hinders when it only has to slide: the presets fade it out.
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
class PointToPoint(StructuredTerm[BodyState]):
    rig: Rig
    matches: Correspondences
    weights: Array  # (M,) robust weight of each match
    sigma: float  # m
    plane_sigma: float | None = None  # m; with it the term stands for `point_to_plane` of the same matches too
    name: str = "point_to_point"

    @cached_property
    def _weighing(self) -> Array:
        """(M, 3, 3) symmetric W with WᵀW = w (I/σ² + nnᵀ/σ_plane²): three rows a match do the work of four."""
        along = 1.0 / self.sigma
        across = along if self.plane_sigma is None else np.hypot(along, 1.0 / self.plane_sigma)
        n = self.matches.normals
        turned = along * np.eye(3) + (across - along) * n[:, :, None] * n[:, None, :]
        return np.asarray(turned * np.sqrt(self.weights)[:, None, None])

    @property
    def _directions(self) -> Array:
        """(3M, 3), axis by axis"""
        return self._weighing.transpose(1, 0, 2).reshape(-1, 3)

    def residual(self, state: BodyState) -> Array:
        """(3M,), axis by axis"""
        gap = state.posed.vertices[self.matches.vertices] - self.matches.points
        return np.asarray(np.einsum("mij,mj->im", self._weighing, gap).ravel())

    def linearise(self, state: BodyState) -> Linearisation:
        """(3M,), (3M, P)"""
        return Linearisation(
            self.residual(state), state.posed.rows(np.tile(self.matches.vertices, 3), self._directions)
        )

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|² by structure, without the Jacobian."""
        chosen = np.tile(self.matches.vertices, 3)
        return normal_equations(state.posed, chosen, self._directions, self.residual(state))
