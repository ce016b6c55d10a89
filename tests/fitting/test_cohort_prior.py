"""A fit with a cohort's prior: nobody changes nothing, a family's women are found where scans show nothing of them."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.example_fit import EXAMPLE, example_task
from scipy.stats import multivariate_normal

from breastrig.correspondence.target import ScanTarget
from breastrig.energies.body_prior import BodyPrior
from breastrig.fitting.body.expected_body import cohort_posterior, expected_body, prior_terms
from breastrig.fitting.fit import FitIterate, fit_iterates
from breastrig.fitting.posterior import Posterior, built_in, contribution, contribution_bytes, parsed_contribution
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.task import FitTask, ended
from breastrig.rig.cohort_prior import CohortPrior, Sums, cohort_of_scans, no_cohort, with_prior
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose

WOMEN = 30
LEFT = 0.01  # m, from where on a scan shows her


@pytest.fixture(scope="module")
def family(rig: Rig) -> CohortPrior:
    """Women with long trunks and large breasts that lie wide apart, whose scans left little open."""
    own = built_in(rig, "standing")
    rng, prior = np.random.default_rng(8), no_cohort(rig)
    for _ in range(WOMEN):
        sums = Sums.of_woman(woman(rig, rng), 0.02 * own.covariance)
        prior = prior.plus(replace(prior, stances={"standing": sums}))
    return prior


def woman(rig: Rig, rng: np.random.Generator) -> np.ndarray:
    """(N,) her scales and weights."""
    scales, weights = np.ones((len(rig.bones), 3)), 0.1 * rng.standard_normal(len(rig.shapes))
    scales[:, 1] += 0.12 + 0.02 * rng.standard_normal()
    for k, name in enumerate(rig.shape_names):
        if name.startswith(("volume_large", "base_width", "lateral")):
            weights[k] += 0.8
    limits = [(shape.min, shape.max) for shape in rig.shapes]
    return np.concatenate([scales.ravel(), np.clip(weights, *np.array(limits).T)])


def last_of(task: FitTask) -> FitIterate:
    *_, last = fit_iterates(task)
    return last


def test_without_women_of_the_stance_it_is_the_built_in_fit_bit_for_bit(rig: Rig, family: CohortPrior) -> None:
    task = example_task()
    plain = last_of(task)
    of_others = replace(family, stances={"supine": family.stances["standing"]})
    for prior in (no_cohort(rig), of_others):
        other = last_of(replace(task, rig=with_prior(rig, prior)))
        assert other.iteration == plain.iteration
        for name, value in plain.parameters.numbers().items():
            assert other.parameters.numbers()[name] == value
    with_them = last_of(replace(task, rig=with_prior(rig, family)))
    assert with_them.parameters.numbers() != plain.parameters.numbers()


def test_what_a_fit_says_of_her_does_not_depend_on_the_prior_that_it_had(rig: Rig, family: CohortPrior) -> None:
    task = example_task()
    last = last_of(task)
    task = ended(task, last)
    found = [
        contribution(Posterior(replace(task, rig=each), last.parameters)) for each in (rig, with_prior(rig, family))
    ]
    x, posterior = last.parameters, Posterior(task, last.parameters)
    np.testing.assert_allclose(found[0].mean, np.concatenate([x.scales.ravel(), x.weights]), atol=1e-6)
    assert np.trace(found[0].covariance) < np.trace(posterior.covariance())
    np.testing.assert_allclose(found[1].covariance, found[0].covariance, atol=1e-5)
    sums = parsed_contribution(contribution_bytes(found[0]), rig, "standing")
    np.testing.assert_allclose(sums.means, found[0].mean, atol=1e-6)


def left_half(rig: Rig, body: np.ndarray) -> tuple[FitTask, np.ndarray, np.ndarray]:
    """Of her scan the left side above the xiphoid, with its landmarks; (V, 3) m all of her, and (V,) what shows."""
    size, x = 3 * len(rig.bones), rest_parameters(rig)
    truth = pose(rig, replace(x, scales=body[:size].reshape(-1, 3), weights=body[size:]))
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(truth, rig.faces), strict=True))
    shown = {name: place for name, place in places.items() if place[0] > LEFT}
    above = (truth[:, 0] > LEFT) & (truth[:, 1] > places["xiphoid"][1])
    used, faces = np.unique(rig.faces[above[rig.faces].all(axis=1)], return_inverse=True)
    target = ScanTarget(truth[used], faces.reshape(-1, 3))
    return FitTask(rig, target, x, load_recipe("default"), {}, "standing").with_picks(shown), truth, above


def off_where_hidden(task: FitTask, truth: np.ndarray, shown: np.ndarray) -> float:
    """m"""
    return float(np.linalg.norm(pose(task.rig, last_of(task).parameters) - truth, axis=1)[~shown].mean())


def test_a_woman_of_the_family_is_found_nearer_where_nothing_shows_her(rig: Rig, family: CohortPrior) -> None:
    """What others lose to women as alike as these is in decision 0027: it may be as much."""
    task, truth, shown = left_half(rig, woman(rig, np.random.default_rng(99)))
    without = off_where_hidden(task, truth, shown)
    known = off_where_hidden(replace(task, rig=with_prior(rig, family)), truth, shown)
    assert known < 0.65 * without, f"{1e3 * without:.1f} mm without, {1e3 * known:.1f} with"


def test_the_geometric_mean_of_both_is_expected(rig: Rig, family: CohortPrior) -> None:
    """Its log density is the mean of theirs, up to a constant."""
    recipe, own, rng = load_recipe("default"), built_in(rig, "standing"), np.random.default_rng(3)
    assert recipe.body is not None
    known = with_prior(rig, family)
    posterior = cohort_posterior(known, recipe.shapes, recipe.body, "standing")
    expected = expected_body(known, recipe.shapes, recipe.body, "standing")
    assert expected is not None
    bodies = own.mean + rng.standard_normal((5, len(own.mean))) @ np.linalg.cholesky(own.covariance).T
    found, theirs, built = (
        multivariate_normal(each.mean, each.covariance).logpdf(bodies) for each in (expected, posterior.expected, own)
    )
    np.testing.assert_allclose(np.diff(found), np.diff(0.5 * (theirs + built)), rtol=1e-6)


def test_a_lying_fit_is_learned_of_and_expected_among_those_who_lie(rig: Rig) -> None:
    task = example_task(EXAMPLE.with_name("supine") / "scan.ply", stance="supine")
    last = last_of(task)
    found = contribution(Posterior(ended(task, last), last.parameters))
    sums = parsed_contribution(contribution_bytes(found), rig, "supine")
    assert sums is not None
    known = with_prior(rig, cohort_of_scans(rig, ((str(number), "supine", sums) for number in range(WOMEN))))
    off = {}
    for stance in ("supine", "standing"):
        own, recipe = built_in(rig, stance), load_recipe("default")
        assert recipe.body is not None
        expected = expected_body(known, recipe.shapes, recipe.body, stance)
        away = np.array([expected.mean, own.mean]) - found.mean
        off[stance] = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(own.covariance), away.T), axis=0)
        again = prior_terms(replace(task, rig=known, stance=stance))[0]
        assert isinstance(again, BodyPrior)
        np.testing.assert_array_equal(again.mean, expected.mean)
    assert off["supine"][0] < 0.8 * off["supine"][1]
    assert off["standing"][0] == off["standing"][1]
