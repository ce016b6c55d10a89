"""What is expected of scales and shapes before any scan: of all women, and of those of a cohort (decision 0027)."""

from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import STANDING
from breastrig.fitting.recipe import Body, Shapes
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.cohort_posterior import CohortPosterior, Gaussian, posterior_of
from breastrig.rig.cohort_prior import cohort_of
from breastrig.rig.model import Rig
from breastrig.rig.stance_priors import in_stance, mean_weights


def expected_shapes(rig: Rig, settings: Shapes, stance: str) -> tuple[Array, Array]:
    """(S,), (S,): expected size and mean of every shape weight."""
    shapes, mean = in_stance(rig, stance).shapes, mean_weights(rig, stance)
    sigma = np.array([settings.sigma or shape.sigma * settings.factor for shape in shapes])
    gravity = np.array([shape.kind == "gravity" for shape in shapes], dtype=np.bool_)
    if stance == "supine":
        return sigma, np.where(gravity, settings.supine_gravity_mean, mean)
    return np.where(gravity & (stance == STANDING), sigma * settings.standing_gravity_factor, sigma), mean


def built_in_body(rig: Rig, shapes: Shapes, body: Body, stance: str) -> Gaussian | None:
    """What is expected of scales and shapes before any scan; None for a rig without statistics of bodies."""
    known, (sigma, mean) = body_statistics(rig), expected_shapes(rig, shapes, stance)
    if known is None:
        return None
    alone = np.concatenate([np.full(3 * len(rig.bones), body.scale_sigma), body.shape_factor * sigma])
    return Gaussian(np.concatenate([known.mean_scales, mean]), body.share * known.covariance + np.diag(alone**2))


@lru_cache(maxsize=16)
def cohort_posterior(rig: Rig, shapes: Shapes, body: Body, stance: str) -> CohortPosterior | None:
    """The posterior of the rig's cohort (rig/cohort_prior.py); None without one, or where it predicts no better."""
    cohort, built_in = cohort_of(rig), built_in_body(rig, shapes, body, stance)
    sums = None if cohort is None else cohort.stances.get(stance)
    if cohort is None or sums is None or built_in is None:
        return None
    return posterior_of(rig, sums, built_in)


def expected_body(rig: Rig, shapes: Shapes, body: Body, stance: str) -> Gaussian | None:
    """The built-in body; with a cohort the geometric mean of both, for the patient may be unlike them."""
    built_in, posterior = built_in_body(rig, shapes, body, stance), cohort_posterior(rig, shapes, body, stance)
    if built_in is None or posterior is None:
        return built_in
    own, theirs = (np.linalg.inv(each.covariance) for each in (built_in, posterior.expected))
    covariance = 2.0 * np.linalg.inv(own + theirs)
    mean = 0.5 * covariance @ (own @ built_in.mean + theirs @ posterior.expected.mean)
    return Gaussian(mean, 0.5 * (covariance + covariance.T))
