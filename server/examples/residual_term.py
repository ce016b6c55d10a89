"""A residual term of your own.

Every energy of the registration is a class with `residual` and `linearise`. This one wants a given distance
between two landmarks; together with the prior it finds the likeliest body whose nipples are so far apart. Its
derivative is checked by finite differences, as each term's is in the tests.
"""

from dataclasses import dataclass

import numpy as np
from PIL import Image

import breastrig
from breastrig.energies.body_prior import BodyPrior
from breastrig.least_squares.problem import Linearisation
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.parameters import BONE_DOFS, rest_parameters
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class LandmarkDistance:
    """r = (|p_a − p_b| − d)/σ for two landmarks a and b."""

    rig: breastrig.Rig
    pair: tuple[str, str]
    distance: float  # m
    sigma: float  # m
    name: str = "landmark_distance"

    def residual(self, state: BodyState) -> np.ndarray:
        """(1,)"""
        a, b = self.rig.landmark_points(self.pair).positions(state.posed.vertices, self.rig.faces)
        return np.array([(np.linalg.norm(a - b) - self.distance) / self.sigma])

    def linearise(self, state: BodyState) -> Linearisation:
        """(1,), (1, P): each end moves with the three corners of its triangle."""
        points = self.rig.landmark_points(self.pair)
        a, b = points.positions(state.posed.vertices, self.rig.faces)
        along = (a - b) / np.linalg.norm(a - b) / self.sigma
        corners = self.rig.faces[points.faces].ravel()  # (6,)
        signs = np.concatenate([points.barycentric[0], -points.barycentric[1]])
        rows = state.posed.rows(corners, signs[:, None] * along)
        return Linearisation(self.residual(state), rows.sum(axis=0, keepdims=True))


def main() -> Image.Image:
    rig = breastrig.load_model()
    known = body_statistics(rig)
    mean = np.concatenate([known.mean_scales, np.zeros(len(rig.shapes))])
    pair = ("nipple_L", "nipple_R")
    start = BodyState(rig, rest_parameters(rig))

    bodies = []
    for millimetres in (160.0, 240.0):
        term = LandmarkDistance(rig, pair, 1e-3 * millimetres, sigma=0.001)
        print(f"derivative: {gradient_error(term, start):.1e} off central differences")
        state = likeliest(start, [BodyPrior(rig, mean, known.covariance + 1e-4 * np.eye(len(mean))), term])
        apart = term.residual(state)[0] + millimetres
        print(f"wanted {millimetres:.0f} mm apart, the likeliest body has {apart:.1f}")
        bodies.append(state.vertices)

    picture = Image.new("RGB", (600, 360))
    for place, body in enumerate(bodies):
        picture.paste(rig.picture(body), (300 * place, 0))
    return picture


def likeliest(state: BodyState, terms: list) -> BodyState:
    """Gauss-Newton over scales and shapes: joints keep their rest."""
    free = np.ones(state.dof, dtype=bool)
    free[: BONE_DOFS * len(state.rig.bones)].reshape(-1, BONE_DOFS)[:, :6] = False
    for _ in range(10):
        parts = [term.linearise(state) for term in terms]
        jacobian = np.concatenate([part.jacobian[:, free] for part in parts])
        residual = np.concatenate([part.residual for part in parts])
        step = np.zeros(state.dof)
        step[free] = -np.linalg.lstsq(jacobian, residual, rcond=None)[0]
        state = state.retract(step)
    return state


def gradient_error(term: LandmarkDistance, state: BodyState) -> float:
    """The largest difference between the Jacobian and central differences, over its largest entry."""
    jacobian = term.linearise(state).jacobian
    step = 1e-6
    numeric = np.stack(
        [
            (term.residual(state.retract(step * unit)) - term.residual(state.retract(-step * unit))) / (2.0 * step)
            for unit in np.eye(state.dof)
        ],
        axis=1,
    )
    return float(np.abs(jacobian - numeric).max() / np.abs(jacobian).max())


if __name__ == "__main__":
    main().save("residual_term.png")
