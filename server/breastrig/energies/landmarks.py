"""Distance of the model's landmarks to where they were observed (E_L, equation 9).

r_l = √w_l L_lᵀ (Σ_c β_lc M_c(x) − q_l) with L_l L_lᵀ the inverse of the observation's covariance and β the barycentric
coordinates in a triangle with corners c; what is known in one direction and not in another pulls in that one only.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState

Source = Literal["pick", "colour", "form", "partner"]
UNKNOWN = 0.1  # m; an error as large as this is none of a place


@dataclass(frozen=True, eq=False)
class LandmarkObservation:
    """An observed location of one landmark of the patient, in the scan's frame."""

    name: str
    place: Array  # (3,) m
    covariance: Array  # (3, 3) m²
    source: Source = "pick"
    outlier: float = 0.0  # 1/m²: odds that another place was meant, spread over the skin
    reason: str = ""  # a few words

    @property
    def error(self) -> float:
        """m, root mean square."""
        return float(np.sqrt(np.trace(self.covariance)))

    @property
    def is_place(self) -> bool:
        """Known on all axes; False for a fold, which does not say where along it the landmark lies."""
        return self.error < UNKNOWN


@dataclass(frozen=True, eq=False)
class Landmarks:
    """L observations, each counted by a weight; their errors are `times` as large as they say."""

    rig: Rig
    observations: Sequence[LandmarkObservation]
    weights: Array | float = 1.0  # (L,)
    times: float = 1.0
    name: str = "landmarks"

    @cached_property
    def points(self) -> SurfacePoints:
        """(L) on the model"""
        return self.rig.landmark_points(tuple(each.name for each in self.observations))

    @cached_property
    def targets(self) -> Array:
        """(L, 3) m"""
        return np.array([each.place for each in self.observations])

    @cached_property
    def whitening(self) -> Array:
        """(L, 3, 3): times a gap, the residual"""
        roots = np.linalg.cholesky(np.linalg.inv([each.covariance for each in self.observations]))
        scale = np.broadcast_to(np.sqrt(self.weights) / self.times, len(roots))
        return np.asarray(scale[:, None, None] * roots.transpose(0, 2, 1))

    def gaps(self, vertices: Array) -> Array:
        """(L, 3) m from the observations to the landmarks of a model with these (V, 3) m vertices"""
        return self.points.positions(vertices, self.rig.faces) - self.targets

    def outliers_from(self) -> Array:
        """(L,) deviations along the skin from which on another place is likelier to have been meant; inf: never."""
        sizes = np.cbrt(np.linalg.det([each.covariance for each in self.observations])) * self.times**2  # m²
        odds = 2.0 * np.pi * sizes * np.array([each.outlier for each in self.observations])
        with np.errstate(divide="ignore"):
            return np.asarray(np.sqrt(np.maximum(-2.0 * np.log(odds), 0.0)))

    def deviations(self, vertices: Array) -> Array:
        """(L,) lengths of the residuals at (V, 3) m vertices"""
        return np.asarray(np.linalg.norm(np.einsum("lij,lj->li", self.whitening, self.gaps(vertices)), axis=1))

    def residual(self, state: BodyState) -> Array:
        """(3L,), axis by axis"""
        return np.asarray(np.einsum("lij,lj->il", self.whitening, self.gaps(state.posed.vertices)).ravel())

    def linearise(self, state: BodyState) -> Linearisation:
        """(3L,), (3L, P)"""
        corners = self.rig.faces[self.points.faces].ravel()  # (3L,)
        directions = np.einsum("lij,lc->ilcj", self.whitening, self.points.barycentric).reshape(-1, 3)  # (9L, 3)
        rows = state.posed.rows(np.tile(corners, 3), directions)
        return Linearisation(self.residual(state), rows[0::3] + rows[1::3] + rows[2::3])  # a landmark's three corners
