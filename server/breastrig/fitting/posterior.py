"""How sure a fit is: the Gaussian at the end of the objective that it has minimised (Laplace's approximation).

The covariance of the unknowns is the inverse of Gauss-Newton's H.  It knows the scan's
noise and the priors, not that the model cannot show every body, so whoever uses it adds that misfit.
"""

from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.problem import ScanProblem
from breastrig.fitting.task import FitTask
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.normal_equations import vertex_variances
from breastrig.rig.parameters import RigParameters
from breastrig.rig.state import BodyState

OF_BODIES = ("body_prior", "scale_prior", "shape_prior")
FLOOR = 1e-6  # of an unknown's natural size: keeps directions that nothing holds out of the inverse


class Posterior:
    """Of a task whose fit ended at `x`."""

    def __init__(self, task: FitTask, x: RigParameters, *, partners: bool = True) -> None:
        """`partners`: what a pick tells of its partner counts; what judges picks lets none vouch for itself."""
        problem, stage = ScanProblem(task, partners=partners), task.recipe.stages[-1]
        self.task, self.state = task, BodyState(task.rig, x)
        terms = problem.terms(stage, 1.0, self.state, problem.matches(stage, 1.0, self.state))
        hessian = problem.system(terms, self.state).hessian
        self._factor = cholesky(hessian + np.diag(FLOOR * problem.scaling))
        self.picks = terms.picks
        self.expected = [term for term in terms.residuals if term.name in OF_BODIES]  # what it expected of the body
        self.relief = problem.relief or {}  # landmarks that the skin's form shows
        self.partners = problem.partners

    @cached_property
    def of_picks_alone(self) -> "Posterior":
        """Without what picks tell of their partners, for judging them."""
        return self if self.partners == () else Posterior(self.task, self.state.x, partners=False)

    def whitened(self, rows: Array) -> Array:
        """(N, P) rows of a Jacobian -> (N, P) whose products with each other are the covariances of what they move."""
        return solve_lower(self._factor, rows.T).T

    def joint_landmark_covariance(self, names: tuple[str, ...]) -> Array:
        """(3 L, 3 L) m², of where the model has these landmarks, together: x, y, z of the first, then of the next."""
        white = self._white_landmarks(names).reshape(3 * len(names), -1)
        return np.asarray(white @ white.T)

    def landmark_covariances(self, names: tuple[str, ...]) -> Array:
        """(L, 3, 3) m², of where the model has each of these landmarks."""
        white = self._white_landmarks(names)
        return np.asarray(white @ white.transpose(0, 2, 1))

    def _white_landmarks(self, names: tuple[str, ...]) -> Array:
        """(L, 3, P), whitened rows of their Jacobian."""
        points = self.task.rig.landmark_points(names)
        corners = self.task.rig.faces[points.faces].ravel()  # (3 L,)
        shares = [(points.barycentric[:, :, None] * axis).reshape(-1, 3) for axis in np.eye(3)]
        moved = [self.state.posed.rows(corners, share) for share in shares]
        return np.stack([self.whitened(rows[0::3] + rows[1::3] + rows[2::3]) for rows in moved], axis=1)

    def landmark_variances(self, names: tuple[str, ...]) -> Array:
        """(L,) m², over all three axes, of where the model has these landmarks."""
        return np.asarray(np.trace(self.landmark_covariances(names), axis1=1, axis2=2))

    def vertex_variances(self) -> Array:
        """(V,) m², over all three axes, of every vertex."""
        return vertex_variances(self.state.posed, self.covariance())

    def covariance(self) -> Array:
        """(P, P) of a step from here, laid out as the unknowns are (rig/parameters.py)."""
        half = self.whitened(np.eye(len(self._factor)))
        return np.asarray(half @ half.T)

    def sample(self, rng: np.random.Generator) -> Array:
        """(P,) a step drawn from the posterior."""
        draw = rng.standard_normal(len(self._factor))
        return solve_lower(self._factor, draw, transposed=True)
