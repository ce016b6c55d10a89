"""A fit's posterior: the Gaussian at the minimum of its objective (Laplace's approximation).

The covariance of the unknowns is the inverse of Gauss-Newton's H. It includes the scan's noise and the priors, not that
the model cannot show every body; that misfit is added where it is used.

A fit's contribution to a cohort is the patient's body under the built-in prior (decision 0027): the posterior of scales
and weights, pose integrated out, is the scan's likelihood times the prior that the fit had; that one is divided out and
the built-in one put in. In its file: float32, the mean, then the covariance's upper triangle row by row; empty where
there is no contribution.
"""

from collections.abc import Collection, Mapping
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.expected_body import built_in_body
from breastrig.fitting.body.landmarks import MIDDLE, NOTCH, XIPHOID, expected_gaps, middle_step
from breastrig.fitting.fit import ScanProblem, mean_distance
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.task import FitTask
from breastrig.least_squares.newton import wide
from breastrig.least_squares.problem import log_student
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.cohort_prior import Sums
from breastrig.rig.model import Rig
from breastrig.rig.normal_equations import vertex_variances
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.state import BodyState

OF_BODIES = ("body_prior", "scale_prior", "shape_prior")
TOGETHER = ("body_prior", "modes")  # what says how unusual a body is
FLOOR = 1e-6  # of an unknown's natural size: keeps directions that nothing holds out of the inverse


class Posterior:
    """The posterior of a task whose fit ended at `x`."""

    def __init__(self, task: FitTask, x: RigParameters, *, partners: bool = True) -> None:
        """`partners`: what a pick tells of its partner counts; what judges picks lets none vouch for itself."""
        problem, stage = ScanProblem(task, partners=partners), task.recipe.stages[-1]
        self.task, self.state = task, BodyState(task.rig, x)
        matches = problem.matches(stage, 1.0, self.state)
        terms = problem.terms(stage, 1.0, self.state, matches)
        hessian = problem.system(terms, self.state).hessian
        self._factor = cholesky(hessian + np.diag(FLOOR * problem.scaling[: x.dof]))
        self.picks = terms.picks
        self.expected = [term for term in terms.residuals if term.name in {*OF_BODIES, *TOGETHER}]
        self.relief = problem.relief or {}  # landmarks that the skin's form shows
        self.partners = problem.partners
        self.distance = mean_distance(matches, np.nan)  # m, to the scan

    @cached_property
    def strain(self) -> float:
        """How little the model can show this body: sqrt(m), the root of the mean distance to the scan, times Birge's
        ratio, how much farther the body is from the mean of bodies than one of their distribution would be; else nan.
        """
        found = [term.linearise(self.state) for term in self.expected if term.name in TOGETHER]
        square = sum(float(each.residual @ each.residual) for each in found)
        usual = sum(len(each.residual) - float(np.sum(self.whitened(each.jacobian) ** 2)) for each in found)
        return float(np.sqrt(self.distance * square / usual)) if usual > 0.0 else np.nan

    @cached_property
    def of_picks_alone(self) -> "Posterior":
        """Without what picks tell of their partners, for judging them."""
        return self if self.partners == () else Posterior(self.task, self.state.x, partners=False)

    def whitened(self, rows: Array) -> Array:
        """(N, P) rows of a Jacobian -> (N, P) whose products with each other are the covariances of what they move."""
        return solve_lower(self._factor, wide(rows, len(self._factor)).T).T

    def joint_landmark_covariance(self, names: tuple[str, ...]) -> Array:
        """(3 L, 3 L) m², of where the model has these landmarks, together: x, y, z of the first, then of the next."""
        white = np.concatenate([np.zeros((0, self.state.x.dof)), *self._white_landmarks(names)])
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


class LeaveOneOut:
    """Leave-one-out residuals of a fit with picks."""

    def __init__(self, posterior: Posterior) -> None:
        picks, task = posterior.picks, posterior.task
        assert picks is not None, "there are no picks to leave out"
        lin = picks.linearise(posterior.state)
        self.names = tuple(task.given)
        count = len(self.names)
        rows = lin.jacobian.reshape(3, count, -1).transpose(1, 0, 2).reshape(3 * count, -1)
        white = posterior.whitened(rows)
        self._hat: Array = white @ white.T  # (3L, 3L)
        self._residual = lin.residual.reshape(3, count).T  # (L, 3), in standard deviations as they count here
        self._unit = np.linalg.inv(picks.whitening)  # (L, 3, 3) m, of these
        self._gaps = picks.gaps(posterior.state.vertices)  # (L, 3) m
        self._own = [each.covariance for each in picks.observations]
        gaps, points = expected_gaps(posterior.state, task.stance), posterior.task.rig.landmark_points(self.names)
        self._expected = [gaps[name] for name in self.names]
        self._normals = points.positions(posterior.state.normals, posterior.task.rig.faces)

    def of_model(self, without: Collection[str] = ()) -> dict[str, tuple[Array, Array]]:
        """Name -> (3,) m from the pick to where all else has the model, (3, 3) m² of both; `without` as in `gaps`."""
        hat, residual = self._hat, self._residual.ravel()
        gone = np.repeat([name in without for name in self.names], 3)
        if gone.any():  # Woodbury: the rows of the picks that are gone leave the normal equations
            push = np.linalg.solve(np.eye(int(gone.sum())) - hat[np.ix_(gone, gone)], np.eye(int(gone.sum())))
            residual = residual + hat[:, gone] @ push @ residual[gone]
            hat = hat + hat[:, gone] @ push @ hat[gone]
        result: dict[str, tuple[Array, Array]] = {}
        for i, name in enumerate(self.names):
            own = slice(3 * i, 3 * i + 3)
            place = hat[own, own]  # of the model's place, in the pick's sigmas
            error: Array = residual[own]
            if name not in without:
                inverse = np.linalg.inv(np.eye(3) - hat[own, own])
                place, error = inverse - np.eye(3), inverse @ error
            unit = self._unit[i]
            result[name] = (unit @ error, unit @ place @ unit.T + self._own[i])
        return result

    def _of_body(self, without: Collection[str]) -> dict[str, tuple[Array, Array]]:
        """The gaps of `of_model`, to the expected landmarks of bodies."""
        parts = zip(self.of_model(without).items(), self._expected, strict=True)
        return {name: (gap + each.mean, cov + each.covariance) for (name, (gap, cov)), each in parts}

    @property
    def distances(self) -> dict[str, float]:
        """Name -> m from the fitted model's landmark to the pick, as it was given."""
        return dict(zip(self.names, map(float, np.linalg.norm(self._gaps, axis=1)), strict=True))

    def gaps(self, without: Collection[str] = ()) -> dict[str, float]:
        """Name -> m for every pick, each left out alone, those in `without` left out all the time."""
        return {name: float(np.linalg.norm(error)) for name, (error, _) in self._of_body(without).items()}

    def deviations(self, without: Collection[str] = ()) -> dict[str, float]:
        """Name -> the gap in standard deviations of what is expected there; `without` as in `gaps`."""
        parts = zip(self._of_body(without).items(), self._normals, strict=True)
        return {name: along_skin(error, covariance, normal) for (name, (error, covariance)), normal in parts}

    def evidence(self) -> dict[str, float]:
        """Name -> nats, the log density of the pick there, each left out alone."""
        parts = zip(self._of_body(()).items(), self._normals, strict=True)
        return {name: evidence_along_skin(error, covariance, normal) for (name, (error, covariance)), normal in parts}


def on_skin(gap: Array, covariance: Array, normal: Array) -> tuple[Array, Array]:
    """(2,) m and (2, 2) m²: a (3,) m gap and its (3, 3) m² covariance along skin with this (3,) normal."""
    tangents = np.linalg.svd(normal[None])[2][1:]  # (2, 3)
    return tangents @ gap, tangents @ covariance @ tangents.T


def along_skin(gap: Array, covariance: Array, normal: Array) -> float:
    """Length of what `on_skin` has, in standard deviations."""
    flat, spread = on_skin(gap, covariance, normal)
    return float(np.sqrt(flat @ np.linalg.solve(spread, flat)))


def evidence_along_skin(gap: Array, covariance: Array, normal: Array) -> float:
    """Nats, the log density (1/m²) of a gap as `on_skin` has it, by a Student t."""
    at_mean = -np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(on_skin(gap, covariance, normal)[1])[1]
    return float(at_mean + log_student(along_skin(gap, covariance, normal), 2))


def meant_evidence(posterior: Posterior, pick: LandmarkObservation, name: str) -> float:
    """Nats, of a pick that was meant for the landmark of this name."""
    rig, state = posterior.task.rig, posterior.state
    point, body = rig.landmark_points((name,)), expected_gaps(state, posterior.task.stance)[name]
    covariance = posterior.landmark_covariances((name,))[0] + body.covariance + pick.covariance
    gap = point.positions(state.vertices, rig.faces)[0] + body.mean - pick.place
    return evidence_along_skin(gap, covariance, point.positions(state.normals, rig.faces)[0])


ON_SKIN = MatchRules(method="tree", max_distance=0.015, max_angle=np.pi / 3)


def laid_on_scan(posterior: Posterior, by_colour: Mapping[str, Array]) -> tuple[Array, Booleans]:
    """((L, 3) m, where the rig's landmarks are expected on the scan's skin; (L,) which of them the scan shows)."""
    rig, target = posterior.task.rig, posterior.task.target
    normals = rig.landmark_points().directions(posterior.state.normals, rig.faces)
    places = expected_places(posterior, by_colour)
    found = match(target, places, normals, ON_SKIN)
    on_scan = np.zeros(len(places), dtype=np.bool_)
    on_scan[found.vertices] = True
    by_form = {name for name, each in posterior.relief.items() if each.is_place}
    laid = [rig.landmark_names[k] not in by_form for k in found.vertices]  # what the form shows stays where it is seen
    places[found.vertices[laid]] = found.points[laid]
    for k, name in enumerate(rig.landmark_names):
        if name in by_form:  # a shoulder's edge tells of its tip
            on_scan[k] = to_skin(target, places[k]) <= ON_SKIN.max_distance
    return places, on_scan


def expected_places(posterior: Posterior, by_colour: Mapping[str, Array]) -> Array:
    """(L, 3) m, where the rig's landmarks are expected: as they are seen, else beside the fitted model's."""
    rig, state = posterior.task.rig, posterior.state
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(state.vertices, rig.faces), strict=True))
    gaps = expected_gaps(state, posterior.task.stance)
    beside = {name: place + gaps[name].mean for name, place in places.items() if name not in posterior.task.landmarks}
    seen = {name: each.place for name, each in posterior.relief.items() if each.is_place} | dict(by_colour)
    expected = places | beside | seen
    if expected.keys() >= {NOTCH, XIPHOID, MIDDLE} and MIDDLE not in {*posterior.task.landmarks, *seen}:
        expected[MIDDLE] = expected[MIDDLE] + middle_step(expected)
    return np.array([*expected.values()]).reshape(-1, 3)


def to_skin(target: ScanTarget, place: Array) -> float:
    """m, to the nearest of the scan's vertices."""
    return float(target.vertex_tree.query(place)[0])


BUILT_IN = "default"  # the preset whose prior is the built-in one
FARTHEST = 2.0  # times the built-in prior's root mean square, over all directions; a woman beyond counts as if there


def built_in(rig: Rig, stance: str) -> Gaussian | None:
    """The prior without any cohort; None for a rig without statistics of bodies."""
    recipe = load_recipe(BUILT_IN)
    return None if recipe.body is None else built_in_body(rig, recipe.shapes, recipe.body, stance)


def contribution(posterior: Posterior) -> Gaussian | None:
    """The contribution; None for a rig without statistics of bodies, or where the numbers break down."""
    task, state = posterior.task, posterior.state
    own, kept = built_in(task.rig, task.stance), body_places(task.rig)
    if own is None:
        return None
    body = np.concatenate([state.x.scales.ravel(), state.x.weights])
    precision = np.linalg.inv(posterior.covariance()[np.ix_(kept, kept)])
    pull = precision @ body
    for term in posterior.expected:
        of_prior = term.linearise(state)
        slope = of_prior.jacobian[:, kept]
        precision -= slope.T @ slope
        pull -= slope.T @ (slope @ body - of_prior.residual)
    before = np.linalg.inv(own.covariance)
    precision += before
    covariance = np.linalg.inv(0.5 * (precision + precision.T))
    mean = covariance @ (pull + before @ own.mean)
    found = Gaussian(mean, 0.5 * (covariance + covariance.T))
    return found if np.isfinite(mean).all() and np.linalg.eigvalsh(found.covariance)[0] > 0.0 else None


def body_places(rig: Rig) -> Array:
    """(N,) indices of the scales of all bones, then of the weights, among the unknowns."""
    first = BONE_DOFS * len(rig.bones)
    scales = np.arange(first).reshape(-1, BONE_DOFS)[:, 6:9].ravel()
    return np.concatenate([scales, np.arange(first, first + len(rig.shapes))])


def contribution_bytes(found: Gaussian | None) -> bytes:
    """The file."""
    if found is None:
        return b""
    upper = found.covariance[np.triu_indices(len(found.mean))]
    return np.concatenate([found.mean, upper]).astype("<f4").tobytes()


def read_contribution(content: bytes, rig: Rig) -> Gaussian | None:
    """The file's Gaussian; None for an empty file, or one of another rig."""
    size = 3 * len(rig.bones) + len(rig.shapes)
    if len(content) != 4 * (size + size * (size + 1) // 2):
        return None
    numbers = np.frombuffer(content, dtype="<f4").astype(np.float64)
    if not np.isfinite(numbers).all():
        return None
    covariance = np.zeros((size, size))
    covariance[np.triu_indices(size)] = numbers[size:]
    return Gaussian(numbers[:size], covariance + np.triu(covariance, 1).T)


def parsed_contribution(content: bytes, rig: Rig, stance: str) -> Sums | None:
    """The patient's sums, bounded; None for an empty file, or one of another rig."""
    own, found = built_in(rig, stance), read_contribution(content, rig)
    if own is None or found is None:
        return None
    root = np.linalg.cholesky(own.covariance)
    away = np.linalg.solve(root, found.mean - own.mean)
    inside = np.linalg.eigvalsh(np.linalg.solve(root, np.linalg.solve(root, found.covariance).T))
    if not (inside[0] > -1e-3 and inside[-1] < 1.0 + 1e-3):  # no posterior is wider than what it began with
        return None
    bound = FARTHEST * np.sqrt(len(away))
    share = min(1.0, bound / max(float(np.linalg.norm(away)), 1e-12))
    return Sums.of_woman(own.mean + root @ (share * away), found.covariance)
