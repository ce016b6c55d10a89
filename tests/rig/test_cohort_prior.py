"""Sums over patients: exact in any order, of one rig, and weighted by how well they predict."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from breastrig.core.errors import BadInput
from breastrig.fitting.posterior import FARTHEST, built_in, parsed_contribution
from breastrig.rig.cohort_posterior import Gaussian, posterior_of
from breastrig.rig.cohort_prior import CohortPrior, Sums, cohort_of, no_cohort, parsed_prior, with_prior
from breastrig.rig.model import Rig

KEPT = 0.1  # of the built-in variance, after a scan
FAMILY = np.array([2.0, -1.5, 1.0])  # where the women's mean is, in units of the built-in prior


@pytest.fixture(scope="module")
def own(rig: Rig) -> Gaussian:
    found = built_in(rig, "standing")
    assert found is not None
    return found


def women(rig: Rig, own: Gaussian, count: int, seed: int, shift: float = 0.0) -> CohortPrior:
    """Of scans that leave KEPT of the built-in variance; all women are `shift` FAMILY away in three directions."""
    rng, root, size = np.random.default_rng(seed), np.linalg.cholesky(own.covariance), len(own.mean)
    prior = no_cohort(rig)
    for _ in range(count):
        truth = rng.standard_normal(size)
        truth[:3] = shift * FAMILY + 0.3 * truth[:3]
        seen = (1.0 - KEPT) * (truth + np.sqrt(KEPT / (1.0 - KEPT)) * rng.standard_normal(size))
        sums = Sums.of_woman(own.mean + root @ seen, KEPT * own.covariance)
        prior = prior.plus(replace(prior, stances={"standing": sums}))
    return prior


def test_cohorts_merge_in_any_order_and_keep_nothing_of_who_is_removed(rig: Rig, own: Gaussian) -> None:
    a, b, c = (women(rig, own, count, seed) for seed, count in enumerate((3, 7, 2)))
    whole = a.plus(b).plus(c).content()
    assert c.plus(a).plus(b).content() == a.plus(b.plus(c)).content() == whole
    assert a.plus(b).plus(c).without(b).content() == a.plus(c).content()
    assert a.without(a).content() == no_cohort(rig).content()
    assert parsed_prior(whole, "p.json").content() == whole


def test_nobody_is_removed_who_is_not_in_it(rig: Rig, own: Gaussian) -> None:
    one, several = women(rig, own, 1, 1), women(rig, own, 5, 2)
    with pytest.raises(BadInput, match="not in the prior"):
        several.without(one)
    with pytest.raises(BadInput, match="not in the prior"):
        no_cohort(rig).without(one)
    with pytest.raises(BadInput, match="another rig"):
        several.without(replace(one, rig_sha256="0" * 64))


def test_a_prior_is_of_one_rig(rig: Rig, own: Gaussian) -> None:
    prior = women(rig, own, 2, 3)
    other = replace(prior, rig_sha256="0" * 64)
    with pytest.raises(BadInput, match="is of another rig"):
        with_prior(rig, other)
    with pytest.raises(BadInput, match="two different rigs"):
        prior.plus(other)
    known = with_prior(rig, prior)
    assert known is with_prior(rig, parsed_prior(prior.content(), "again"))
    found = cohort_of(known)
    assert found.content() == prior.content()
    assert with_prior(rig, no_cohort(rig)) is rig


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda d: d.update(schema="breastrig/prior@2"), "schema"),
        (lambda d: d.update(surprise=1), "surprise"),
        (lambda d: d["stances"]["standing"].update(women=0), "women"),
        (lambda d: d["stances"]["standing"]["means"].pop(), "hold together"),
        (lambda d: d["stances"]["standing"]["means"].__setitem__(0, 1e300), "means"),
        (lambda d: d["stances"]["standing"]["products"].__setitem__(0, -5.0), "hold together"),
        (lambda d: d["stances"]["standing"].update(products=[], covariances=[]), "hold together"),
        (lambda d: d["bones"].extend(["b"] * 2000), "bones"),
        (lambda d: d["stances"].update(dancing=d["stances"]["standing"]), "dancing"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_sentence(rig: Rig, own: Gaussian, change: Any, why: str) -> None:
    document = json.loads(women(rig, own, 3, 4).content())
    change(document)
    with pytest.raises(BadInput, match=why) as caught:
        parsed_prior(json.dumps(document), "p.json")
    assert str(caught.value).count("\n") == 0
    for text in ("", "[]", "{" * 100_000, "null", '{"schema": NaN}'):
        with pytest.raises(BadInput, match=r"p\.json is no prior"):
            parsed_prior(text, "p.json")


def test_women_of_a_family_move_the_mean_and_narrow_what_they_share(rig: Rig, own: Gaussian) -> None:
    root = np.linalg.cholesky(own.covariance)
    sums = women(rig, own, 60, 5, shift=1.0).stances["standing"]
    posterior = posterior_of(rig, sums, own)
    whitened = np.linalg.solve(root, np.linalg.solve(root, posterior.expected.covariance).T)
    assert np.linalg.eigvalsh(whitened).min() > 0.0
    assert posterior.gain > 1.0
    mean = np.linalg.solve(root, sums.means / sums.women - own.mean)
    found = np.linalg.solve(root, posterior.expected.mean - own.mean)
    share = sums.women / (sums.women + posterior.mean_strength)  # the built-in prior has the rest
    for axis in np.eye(len(mean))[:3]:  # in which the patients differ from it
        assert found @ axis == pytest.approx(share * mean @ axis, abs=0.05 * np.abs(FAMILY).max())
    few = posterior_of(rig, women(rig, own, 6, 5, shift=1.0).stances["standing"], own)
    assert few is None or few.gain < posterior.gain


def test_women_as_the_built_in_prior_has_them_change_it_little(rig: Rig, own: Gaussian) -> None:
    """Patients like the built-in prior improve on it by almost nothing."""
    root = np.linalg.cholesky(own.covariance)
    posterior = posterior_of(rig, women(rig, own, 30, 6).stances["standing"], own)
    if posterior is not None:
        away = np.linalg.solve(root, posterior.expected.mean - own.mean)
        assert np.linalg.norm(away) < 0.1 * np.sqrt(len(away))
        assert posterior.gain < 0.3


def test_no_side_is_preferred(rig: Rig, own: Gaussian) -> None:
    from breastrig.rig.cohort_posterior import mirrored_places

    other = mirrored_places(rig)
    symmetric = Gaussian(
        0.5 * (own.mean + own.mean[other]), 0.5 * (own.covariance + own.covariance[np.ix_(other, other)])
    )
    posterior = posterior_of(rig, women(rig, own, 30, 7, shift=1.0).stances["standing"], symmetric)
    np.testing.assert_allclose(posterior.expected.mean, posterior.expected.mean[other], atol=1e-9)
    np.testing.assert_allclose(
        posterior.expected.covariance, posterior.expected.covariance[np.ix_(other, other)], atol=1e-9
    )


def test_a_woman_beyond_all_bounds_counts_as_one_at_the_bound(rig: Rig, own: Gaussian) -> None:
    root, upper = np.linalg.cholesky(own.covariance), np.triu_indices(len(own.mean))

    def content(times: float) -> bytes:
        mean = own.mean + times * root[:, 0]
        return np.concatenate([mean, 0.5 * own.covariance[upper]]).astype("<f4").tobytes()

    bound = FARTHEST * np.sqrt(len(own.mean))
    far = parsed_contribution(content(100.0 * bound), rig, "standing")
    near = parsed_contribution(content(0.5 * bound), rig, "standing")
    assert np.linalg.norm(np.linalg.solve(root, far.means - own.mean)) == pytest.approx(bound, rel=1e-4)
    np.testing.assert_allclose(near.means, own.mean + 0.5 * bound * root[:, 0], atol=1e-5)
    for wrong in (b"", content(1.0)[:-4], content(float("nan")), content(1.0)[:328] + content(1.0)[:328] * 41):
        assert parsed_contribution(wrong, rig, "standing") is None


def test_one_woman_is_a_cohort_that_nobody_believes(rig: Rig, own: Gaussian) -> None:
    one = women(rig, own, 1, 9, shift=1.0)
    assert parsed_prior(one.content(), "p.json").content() == one.content()
    assert posterior_of(rig, one.stances["standing"], own) is None
