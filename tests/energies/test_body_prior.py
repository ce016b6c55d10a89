"""Two bodies of equal odds: the scan decides by evidence, not by which of them is the narrower."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.random_pose import random_parameters

from breastrig.energies.body_prior import BodyPrior, EitherBody
from breastrig.least_squares.newton import System
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState


@pytest.fixture
def state(toy_rig: Rig) -> BodyState:
    return BodyState(toy_rig, random_parameters(toy_rig, np.random.default_rng(1)))


def body_of(state: BodyState) -> np.ndarray:
    return np.concatenate([state.x.scales.ravel(), state.x.weights])


def prior(state: BodyState, away: float, spread: float, seed: int) -> BodyPrior:
    size = len(body_of(state))
    factors = np.random.default_rng(seed).normal(size=(size, size))
    return BodyPrior(state.rig, body_of(state) + away, spread * (factors @ factors.T / size + np.eye(size)))


def observed(state: BodyState, sigma: float, seed: int = 4) -> System:
    """A Gaussian about a place near the state, sigma wide in each unknown."""
    gap = 0.1 * np.random.default_rng(seed).normal(size=state.x.dof)
    none = np.zeros(0)
    return System(np.eye(state.x.dof) / sigma**2, gap / sigma**2, np.zeros((0, state.x.dof)), none, none, 0.0)


def test_the_evidence_is_that_of_two_gaussians_multiplied(state: BodyState) -> None:
    """Against the closed form: the observation as if drawn from the prior widened by its noise."""
    sigma, places = 0.3, np.flatnonzero(prior(state, 0.0, 1.0, 0).linearise(state).jacobian.any(axis=0))
    others = observed(state, sigma)
    found, expected = [], []
    for seed in range(3):
        each = prior(state, 0.2 * seed, 1.0 + seed, seed)
        found.append(each.evidence(state, others))
        seen = body_of(state) - others.gradient[places] * sigma**2
        wide = each.covariance + sigma**2 * np.eye(len(seen))
        away = seen - each.mean
        expected.append(-0.5 * away @ np.linalg.solve(wide, away) - 0.5 * np.linalg.slogdet(wide)[1])
    np.testing.assert_allclose(np.diff(found), np.diff(expected), atol=1e-6)


def test_what_shows_nothing_prefers_neither_also_where_one_is_narrower(state: BodyState) -> None:
    wide, narrow = prior(state, 0.0, 1.0, 1), prior(state, 0.0, 1.0, 1)
    narrow = replace(narrow, covariance=0.01 * narrow.covariance)
    blind = replace(observed(state, 1e4), gradient=np.zeros(state.x.dof))
    counted = EitherBody(narrow, wide).weighted(state, blind)
    both = 0.5 * (narrow.precision + wide.precision)
    np.testing.assert_allclose(counted.precision, both, rtol=1e-3)
    assert narrow.evidence(state, blind) == pytest.approx(wide.evidence(state, blind), abs=1e-3)


def test_a_woman_is_of_the_cohort_where_she_speaks_for_it_as_its_women_do(state: BodyState) -> None:
    """Its women's evidence is on the mean as much larger as is expected; far from it the other body is all there is."""
    rng, others = np.random.default_rng(5), observed(state, 0.3)
    others = replace(others, gradient=np.zeros(state.x.dof))
    cohort, all_women = prior(state, 0.3, 0.5, 2), prior(state, -0.3, 1.5, 3)
    either = EitherBody(cohort, all_women)
    root, size = np.linalg.cholesky(cohort.covariance), 3 * len(state.rig.bones)
    gains = []
    for _ in range(400):
        seen = cohort.mean + root @ rng.standard_normal(len(root)) + 0.3 * rng.standard_normal(len(root))
        x = replace(state.x, scales=seen[:size].reshape(-1, 3), weights=seen[size:])
        there = BodyState(state.rig, x)
        gains.append(cohort.evidence(there, others) - all_women.evidence(there, others))
    expected = either.expected_gain(others)
    assert abs(np.mean(gains) - expected) < 4.0 * np.std(gains) / np.sqrt(len(gains))
    assert expected > 0.0
    far = EitherBody(replace(cohort, mean=cohort.mean + 9.0), all_women)
    assert far.weighted(state, others) is far.second
