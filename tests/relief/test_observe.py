"""Hollows of a landmark found on simple skins whose truth is known, and none where there is none."""

from collections.abc import Callable

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.relief.limits import relief
from breastrig.relief.observe import Expected, is_on_smooth_skin, relief_observations

SPACING, HALF = 0.005, 0.15  # m, of the scan's vertices, and half its side
FRONT = np.array([0.0, 0.0, 1.0])
NAVEL, FOLD, NOTCH = "umbilicus", "inframammary_fold_L", "suprasternal_notch"

Heights = Callable[[Array, Array], Array]


def belly(x: Array, y: Array) -> Array:
    """m; rounder across than along."""
    return np.asarray(-(x**2) / 0.5 - y**2 / 0.9)


def dent(x: Array, y: Array, at: tuple[float, float]) -> Array:
    """m, 8 mm deep and 25 mm wide."""
    return np.asarray(-0.008 * np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2.0 * 0.007**2)))


def skin(heights: Heights, noise: float = 0.001, seed: int = 3) -> ScanTarget:
    """A scan of z = heights(x, y), seen from the front."""
    rng = np.random.default_rng(seed)
    steps = np.arange(-HALF, HALF + 1e-9, SPACING)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    x, y = (each + rng.uniform(-0.3, 0.3, len(each)) * SPACING for each in (x, y))
    z = heights(x, y) + noise * rng.normal(size=len(x))
    count = len(steps)
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + count + 1], axis=1),
            np.stack([corner, corner + count + 1, corner + count], axis=1),
        ]
    )
    return ScanTarget(np.column_stack([x, y, z]), faces)


def seen(target: ScanTarget, name: str, heights: Heights) -> LandmarkObservation | None:
    """What is seen of a landmark that the form expects in the middle."""
    place = np.array([0.0, 0.0, float(heights(np.zeros(1), np.zeros(1))[0])])
    return relief_observations(target, {name: Expected(place, FRONT)}, np.eye(3)).get(name)


@pytest.mark.parametrize("at", [(0.0, 0.03), (0.005, -0.04), (-0.004, 0.0)])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_navel_is_found_where_its_dent_is(at: tuple[float, float], seed: int) -> None:
    found = seen(skin(lambda x, y: belly(x, y) + dent(x, y, at), seed=seed), NAVEL, belly)
    assert found.is_place
    assert found.reason == "dent seen"
    off = found.place - [*at, float((belly(*np.array([at]).T) + dent(*np.array([at]).T, at))[0])]
    assert np.linalg.norm(off[:2]) < 0.005
    assert abs(off[2]) < 0.004  # at its bottom, not over it
    assert off @ np.linalg.solve(found.covariance, off) < 3.0**2
    assert found.error < 0.012


@pytest.mark.parametrize("seed", range(4))
def test_a_smooth_belly_shows_no_navel(seed: int) -> None:
    assert seen(skin(belly, seed=seed), NAVEL, belly) is None


def test_a_groove_along_the_belly_does_not_say_how_high_the_navel_is() -> None:
    def grooved(x: Array, y: Array) -> Array:
        return np.asarray(belly(x, y) - 0.006 * np.exp(-(x**2) / (2.0 * 0.008**2)))

    assert seen(skin(grooved), NAVEL, belly) is None


def test_a_navel_that_the_scan_does_not_show_is_not_seen() -> None:
    """Neither where skin is missing nor where the scan ends beside it."""
    whole = skin(lambda x, y: belly(x, y) + dent(x, y, (0.0, 0.03)))
    x, y = whole.vertices[:, 0], whole.vertices[:, 1]
    for covered in (np.hypot(x, y - 0.03) < 0.03, y > 0.01):
        faces = whole.faces[~covered[whole.faces].any(axis=1)]
        used, renumbered = np.unique(faces, return_inverse=True)
        part = ScanTarget(whole.vertices[used], renumbered.reshape(-1, 3))
        assert seen(part, NAVEL, belly) is None


def test_two_dents_are_not_one_between_them() -> None:
    """Their mean is nobody's place: the error reaches both, or nothing is seen."""
    found = seen(skin(lambda x, y: belly(x, y) + dent(x, y, (0.0, 0.03)) + dent(x, y, (0.0, -0.03))), NAVEL, belly)
    if found is not None:
        assert np.sqrt(found.covariance[1, 1]) > 0.02


def furrow(x: Array, y: Array) -> Array:
    """m; a breast's lower edge that meets the belly 6 mm above the middle, all along."""
    return np.asarray(belly(x, y) + np.maximum(0.0, y - 0.006) * 0.9)


def test_a_fold_says_how_high_it_is_and_not_where_along_it_the_landmark_lies() -> None:
    found = seen(skin(furrow), FOLD, belly)
    assert not found.is_place
    up = np.array([0.0, 1.0, 0.0])
    assert abs(found.place @ up - 0.006) < 0.003
    axes, deviations = np.linalg.eigh(found.covariance)[1], np.sqrt(np.linalg.eigvalsh(found.covariance))
    assert deviations[2] > 0.5  # m: nothing is known there
    assert abs(axes[:, 2] @ [1.0, 0.0, 0.0]) > 0.95
    assert deviations[1] < 0.007
    assert seen(skin(belly), FOLD, belly) is None


def test_a_notch_is_drawn_to_where_the_profile_is_most_concave() -> None:
    def neck(x: Array, y: Array) -> Array:
        bend = np.maximum(0.0, y - 0.012)
        return np.asarray(-(x**2) / 0.5 + 0.6 * bend - dent(x, y, (0.0, 0.012)) * -0.5)

    found = seen(skin(neck), NOTCH, neck)
    off = found.place - [0.0, 0.012, found.place[2]]
    assert np.linalg.norm(off) < 0.007
    assert off @ np.linalg.solve(found.covariance, off) < 2.0**2


def test_what_is_seen_moves_and_turns_with_the_scan() -> None:
    def navel(x: Array, y: Array) -> Array:
        return np.asarray(belly(x, y) + dent(x, y, (0.0, 0.02)))

    target = skin(navel)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([3.0, -1.0, 0.5])
    moved = ScanTarget(target.vertices @ turn.T + shift, target.faces)
    here = relief_observations(target, {NAVEL: Expected(np.zeros(3), FRONT)}, np.eye(3))[NAVEL]
    there = relief_observations(moved, {NAVEL: Expected(shift, turn @ FRONT)}, turn)[NAVEL]
    np.testing.assert_allclose(there.place, turn @ here.place + shift, atol=1e-5)
    np.testing.assert_allclose(there.covariance, turn @ here.covariance @ turn.T, atol=1e-7)


def test_a_landmark_without_a_hollow_is_not_looked_for() -> None:
    target = skin(lambda x, y: belly(x, y) + dent(x, y, (0.0, 0.0)))
    assert relief_observations(target, {"nipple_L": Expected(np.zeros(3), FRONT)}, np.eye(3)) == {}
    assert {"umbilicus", "suprasternal_notch", "inframammary_fold"} == set(relief().concavities)


def test_next_to_no_skin_shows_nothing() -> None:
    few = ScanTarget(np.random.default_rng(0).normal(size=(30, 3)), np.arange(30).reshape(10, 3))
    assert relief_observations(few, {NAVEL: Expected(np.zeros(3), FRONT)}, np.eye(3)) == {}


@pytest.mark.parametrize("seed", [1, 2])
def test_skin_beside_a_dent_is_smooth_and_skin_in_it_is_not(seed: int) -> None:
    at = (0.005, -0.04)
    target = skin(lambda x, y: belly(x, y) + dent(x, y, at), seed=seed)

    def smooth(name: str, x: float, y: float) -> bool:
        place = np.array([x, y, float(belly(np.array(x), np.array(y)))])
        concavity = relief().concavity(name)
        assert concavity is not None
        return is_on_smooth_skin(target, concavity, Expected(place, FRONT), np.eye(3))

    assert smooth(NAVEL, 0.005, 0.0)
    assert smooth(NAVEL, 0.045, -0.04)
    assert not any(smooth(NAVEL, at[0] + x, at[1] + y) for x, y in ((0.0, 0.0), (0.005, 0.0), (-0.003, -0.004)))
    assert not smooth(NAVEL, 0.0, 0.3), "where the scan shows nothing, nothing is told"
    assert not smooth(NOTCH, 0.005, 0.0), "nor of a landmark without a limit"
