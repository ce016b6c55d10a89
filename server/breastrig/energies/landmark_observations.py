"""Distance of the model's landmarks to observations of them, each with a covariance of its own.

r_l = L_lᵀ (Σ_c β_lc M_c(x) − q_l) with L_l L_lᵀ the inverse of the covariance, so that what is known in one direction
and not in another pulls in that direction only; else as `landmarks`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class LandmarkObservations:
    rig: Rig
    points: SurfacePoints  # (L) on the model
    targets: Array  # (L, 3) m, observed on the scan
    covariances: Array  # (L, 3, 3) m²
    name: str = "landmark_observations"

    @cached_property
    def _whitening(self) -> Array:
        """(L, 3, 3): times a gap, the residual"""
        return np.asarray(np.linalg.cholesky(np.linalg.inv(self.covariances)).transpose(0, 2, 1))

    def residual(self, state: BodyState) -> Array:
        """(3L,), axis by axis"""
        gap = self.points.positions(state.posed.vertices, self.rig.faces) - self.targets
        return np.asarray(np.einsum("lij,lj->il", self._whitening, gap).ravel())

    def linearise(self, state: BodyState) -> Linearisation:
        """(3L,), (3L, P)"""
        corners = self.rig.faces[self.points.faces].ravel()  # (3L,)
        directions = np.einsum("lij,lc->ilcj", self._whitening, self.points.barycentric).reshape(-1, 3)  # (9L, 3)
        rows = state.posed.rows(np.tile(corners, 3), directions)
        return Linearisation(self.residual(state), rows[0::3] + rows[1::3] + rows[2::3])  # a landmark's three corners
