"""Distance of matched model vertices to their scan point, all three axes (E_D, equation 7, as printed).

r_m = √w_m (M_m(x) − p_m) / σ.  Holds the model along the surface too, which helps while it is far away and
hinders when it only has to slide: the presets fade it out.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import Correspondences
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import posed


@dataclass(frozen=True, eq=False)
class PointToPoint:
    rig: Rig
    matches: Correspondences
    weights: Array  # (M,) robust weight of each match
    sigma: float  # m
    name: str = "point_to_point"

    def residual(self, x: RigParameters) -> Array:
        """(3M,), axis by axis"""
        gap = posed(self.rig, x).vertices[self.matches.vertices] - self.matches.points
        return np.asarray((gap * (np.sqrt(self.weights) / self.sigma)[:, None]).T.ravel())

    def linearise(self, x: RigParameters) -> Linearisation:
        """(3M,), (3M, P)"""
        scale = np.sqrt(self.weights) / self.sigma
        directions = (np.eye(3)[:, None] * scale[:, None]).reshape(-1, 3)  # (3M, 3)
        return Linearisation(self.residual(x), posed(self.rig, x).rows(np.tile(self.matches.vertices, 3), directions))
