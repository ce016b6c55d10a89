"""The prior for the next patient from sums over patients: normal-inverse-Wishart, centred on the built-in prior.

In coordinates in which the built-in prior is standard normal, and only in directions in which scans showed more than
it: mean ~ N(0, Σ/κ), Σ ~ IW(ν), scaled so that the built-in prior is the expectation before the first patient. κ and ν
maximise the marginal likelihood, closed forms of multivariate t: the mean over all ways to leave some patients out and
to predict them from the rest (Fong and Holmes, 2020; decision 0027).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import multigammaln

from breastrig.core.arrays import Array, Integers
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.cohort_prior import Sums
from breastrig.rig.model import Rig

FEWEST = 30  # patients; of ten nothing is gained yet, and the skin of others is farther (decision 0027)
SHOWN = 0.5  # share of its built-in variance that a direction keeps on the mean, at most, to be learned from scans
PRIOR_STRENGTHS = np.geomspace(0.5, 4096.0, 27)  # candidate weights of the built-in prior, in patients
TOO_MANY = 1e6  # likewise: the built-in prior alone counts


@dataclass(frozen=True, eq=False)
class Gaussian:
    """A Gaussian over N scales and weights."""

    mean: Array  # (N,)
    covariance: Array  # (N, N)


@dataclass(frozen=True, eq=False)
class CohortPosterior:
    """The posterior predictive distribution for the next patient, with its evidence."""

    expected: Gaussian
    women: int
    mean_strength: float  # weight of the built-in prior, in patients, for the mean (κ) ...
    spread_strength: float  # ... and for the covariance (ν - K - 1)
    directions: int  # K, that were learned of
    gain: float  # mean log predictive density of a patient's directions over the built-in prior's, nats

    @property
    def closer(self) -> float:
        """The gain, expressed as the share by which an interval for each direction would be narrower."""
        return float(-np.expm1(-self.gain / self.directions))


def mirrored_places(rig: Rig) -> Integers:
    """(N,) indices of the other side's scales and weights; the scales' axes are alike on both sides."""
    bones = [rig.bone_names.index(bone.mirror) for bone in rig.bones]
    shapes = [rig.shape_names.index(shape.mirror) for shape in rig.shapes]
    scales = (3 * np.array(bones)[:, None] + np.arange(3)).ravel()
    return np.concatenate([scales, 3 * len(bones) + np.array(shapes, dtype=np.int64)])


def posterior_of(rig: Rig, sums: Sums, built_in: Gaussian) -> CohortPosterior | None:
    """The posterior of these sums; None where patients are few or it predicts no better than the built-in prior."""
    if sums.women < FEWEST:
        return None
    n, root, mirror = sums.women, cholesky(built_in.covariance), mirrored_places(rig)
    root = np.tril(root)
    mean = 0.5 * (sums.means + sums.means[mirror]) / n  # each patient, also mirrored: no side is preferred
    centred = solve_lower(root, mean - built_in.mean)
    about = sums.products / n - np.outer(sums.means, sums.means) / n**2
    about, kept = (0.5 * (each + each[np.ix_(mirror, mirror)]) for each in (about, sums.covariances / n))
    away = 0.5 * (sums.means - sums.means[mirror]) / n
    about = about + np.outer(away, away)
    about, kept = (_whitened(root, each) for each in (about, kept))
    shares, axes = np.linalg.eigh(kept)
    axes = axes[:, shares < SHOWN]
    if not axes.shape[1]:
        return None
    inside, scatter = axes.T @ centred, n * axes.T @ (about + kept) @ axes
    evidence = _Evidence(n, inside, scatter)
    strengths = np.array([*PRIOR_STRENGTHS, TOO_MANY])
    found = np.array([[evidence.at(k, b) for b in strengths] for k in strengths])
    best = np.unravel_index(int(found.argmax()), found.shape)
    gain = float(found[best] - evidence.at(TOO_MANY, TOO_MANY)) / n
    if gain <= 0.0:
        return None
    k, b = float(strengths[best[0]]), float(strengths[best[1]])
    spread = evidence.spread(k, b) * (k + n + 1.0) / ((k + n) * (b + n))
    turned = root @ axes
    expected = Gaussian(
        built_in.mean + turned @ (n / (k + n) * inside),
        built_in.covariance + turned @ (spread - np.eye(len(inside))) @ turned.T,
    )
    return CohortPosterior(expected, n, k, b, len(inside), gain)


def _whitened(root: Array, matrix: Array) -> Array:
    """(N, N): L⁻¹ M L⁻ᵀ."""
    half = solve_lower(root, matrix)
    whole = solve_lower(root, half.T)
    return np.asarray(0.5 * (whole + whole.T))


class _Evidence:
    """Logarithm of the marginal likelihood of n women with this mean (K,) and scatter (K, K) about it."""

    def __init__(self, n: int, mean: Array, scatter: Array) -> None:
        self._n, self._mean, self._scatter = n, mean, scatter
        self._sizes, axes = np.linalg.eigh(scatter)
        self._along = (axes.T @ mean) ** 2

    def spread(self, k: float, b: float) -> Array:
        """(K, K) scale matrix of the inverse Wishart after all patients."""
        pull = k * self._n / (k + self._n)
        return b * k / (k + 1.0) * np.eye(len(self._mean)) + self._scatter + pull * np.outer(self._mean, self._mean)

    def at(self, k: float, b: float) -> float:
        """The log evidence with built-in priors worth k and b patients, up to a constant."""
        n, size = self._n, len(self._mean)
        if b >= TOO_MANY:  # a Gaussian of known covariance
            known = k / (k + 1.0)
            squares = self._sizes.sum() + k * n / (k + n) * self._along.sum()
            return float(0.5 * size * np.log(k / (k + n)) - 0.5 * n * size * np.log(known) - 0.5 * squares / known)
        nu, scale = b + size + 1.0, b * k / (k + 1.0)
        pull = k * n / (k + n)
        log_det = np.log(scale + self._sizes).sum() + np.log1p(pull * (self._along / (scale + self._sizes)).sum())
        found = multigammaln(0.5 * (nu + n), size) - multigammaln(0.5 * nu, size) + 0.5 * n * size * np.log(2.0)
        found += 0.5 * nu * size * np.log(scale) - 0.5 * (nu + n) * log_det + 0.5 * size * np.log(k / (k + n))
        return float(found)
