"""One fit's contribution to a cohort: the patient's body under the built-in prior (decision 0027).

The fit's posterior of scales and weights, pose integrated out, is the scan's likelihood times the prior that the fit
had; that one is divided out and the built-in one put in. In its file: float32, the mean, then the covariance's upper
triangle row by row; empty where there is no contribution.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.body.expected_body import built_in_body
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.cohort_prior import Sums
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS

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
