"""Many similarities at once are each the one that `umeyama` finds alone."""

import numpy as np

from breastrig.geometry.rotations import exp_so3
from breastrig.rig.similarity import Similarities, Similarity, nearest_similarities, umeyama


def test_each_is_what_umeyama_finds_over_its_own_pairs() -> None:
    rng = np.random.default_rng(3)
    source = rng.normal(size=(40, 3))
    targets = (
        1.05 * source @ exp_so3(np.array([0.3, -1.0, 0.4])).T + 0.1 * rng.normal(size=(6, 40, 3)) + [1.0, 2.0, -3.0]
    )
    used = rng.random((6, 40)) > 0.4
    found = nearest_similarities(source, targets, used)
    for number in range(6):
        alone = umeyama(source[used[number]], targets[number][used[number]])
        one = found.one(number)
        assert np.isclose(one.scale, alone.scale, rtol=1e-12)
        assert np.allclose(one.rotation, alone.rotation, atol=1e-12)
        assert np.allclose(one.translation, alone.translation, atol=1e-12)


def test_a_scale_out_of_bounds_stops_there_and_the_means_still_meet() -> None:
    rng = np.random.default_rng(4)
    source = rng.normal(size=(30, 3))
    found = nearest_similarities(source, 2.0 * source[None] + [1.0, 0.0, 0.0], np.ones((1, 30), bool), (0.9, 1.1))
    assert found.scales == [1.1]
    assert np.allclose(found.apply(source).mean(axis=1), 2.0 * source.mean(axis=0) + [1.0, 0.0, 0.0])


def test_a_mirrored_body_is_not_mirrored_back() -> None:
    source = np.random.default_rng(5).normal(size=(30, 3))
    found = nearest_similarities(source, source[None] * [-1.0, 1.0, 1.0], np.ones((1, 30), bool))
    assert np.isclose(np.linalg.det(found.rotations[0]), 1.0)


def test_apply_and_undone_are_inverse_and_the_choice_is_by_try() -> None:
    rng = np.random.default_rng(6)
    each = [Similarity(rng.uniform(0.9, 1.1), exp_so3(rng.normal(size=3)), rng.normal(size=3)) for _ in range(3)]
    tries = Similarities.of(each)
    points = rng.normal(size=(5, 3))
    moved = tries.apply(points)
    for number, one in enumerate(each):
        assert np.allclose(moved[number], one.apply(points))
        assert np.allclose(tries.undone(moved[number])[number], points)
    assert np.array_equal(tries.chosen(np.array([2, 0])).translations, tries.translations[[2, 0]])
    mixed = tries.where(np.array([True, False, False]), tries.chosen(np.array([2, 2, 0])))
    assert np.array_equal(mixed.scales, tries.scales[[0, 2, 0]])
