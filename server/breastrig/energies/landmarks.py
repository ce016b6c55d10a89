"""Distance of the model's landmarks to the picked points (E_L, equation 9).

r_l = (Σ_c β_lc M_c(x) − q_l) / σ_l, all three axes; a landmark is a surface point with barycentric
coordinates β of its triangle's corners c.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class Landmarks:
    rig: Rig
    points: SurfacePoints  # (L) on the model
    targets: Array  # (L, 3) m, picked on the scan
    sigma: Array  # (L,) m, expected error of each pick
    name: str = "landmarks"

    def residual(self, state: BodyState) -> Array:
        """(3L,), axis by axis"""
        gap = self.points.positions(state.posed.vertices, self.rig.faces) - self.targets
        return np.asarray((gap / self.sigma[:, None]).T.ravel())

    def linearise(self, state: BodyState) -> Linearisation:
        """(3L,), (3L, P)"""
        body = state.posed
        corners = self.rig.faces[self.points.faces].ravel()  # (3L,)
        weight = (self.points.barycentric / self.sigma[:, None]).ravel()
        directions = (np.eye(3)[:, None] * weight[:, None]).reshape(-1, 3)  # (9L, 3)
        rows = body.rows(np.tile(corners, 3), directions)
        return Linearisation(self.residual(state), rows[0::3] + rows[1::3] + rows[2::3])  # a landmark's three corners
