"""What is estimated of breasts under gravity, on women drawn from a Gaussian that is known: radii hold nine of ten."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.predicted import FILE, STANCES, TENTH, GravityPrior, Way, gravity_prior, posture
from breastrig_studies.gravity import estimate, two_stances
from breastrig_studies.gravity.estimate import Woman, document, gaussian, misses, with_band, with_lying_mean

PLACES, KINDS = 60, 4  # vertices, and ways in which women differ
BREAST = np.arange(PLACES) < 45  # the others hardly move


def women(count: int, seed: int, places: int = PLACES) -> list[Woman]:
    """Who differ in KINDS ways, standing and in what gravity does, here and there by a few millimetres."""
    drawn, rng = np.random.default_rng(1), np.random.default_rng(seed)
    breast = (np.arange(places) < 0.75 * places).astype(float)
    ways = {
        name: drawn.normal(0.0, size, (KINDS, places * 3))
        for name, size in zip(STANCES, (8e-3, 3e-3, 5e-3), strict=True)
    }
    mean = {name: drawn.normal(0.0, 5e-3, places * 3) for name in STANCES}
    moved = np.repeat(0.2 + 0.8 * breast, 3)
    found = []
    for number in range(count):
        z = rng.normal(size=KINDS)
        standing = mean["standing"] + z @ ways["standing"]
        heights = {"standing": standing}
        heights |= {name: standing + moved * (mean[name] + z @ ways[name]) for name in STANCES[1:]}
        found.append(Woman(number, heights))
    return found


def test_of_women_who_differ_in_a_few_ways_the_gaussian_is_their_own() -> None:
    known = women(30, 2)
    prior = gaussian(known)
    rows = {name: np.array([woman.heights[name] for woman in known]) for name in STANCES}
    for one in STANCES:
        assert prior.mean[one] == pytest.approx(rows[one].mean(axis=0))
        for other in STANCES:
            among = (rows[one] - rows[one].mean(axis=0)).T @ (rows[other] - rows[other].mean(axis=0)) / len(known)
            assert prior.factors[one].T @ prior.factors[other] == pytest.approx(among, abs=1e-9)


@pytest.mark.parametrize("goal", STANCES[1:])
def test_radii_hold_nine_of_ten_places_of_women_who_come_later(goal: str) -> None:
    prior = with_band(gaussian(women(60, 3)), women(60, 4), BREAST)
    miss, radii = (each[:, BREAST] for each in misses(prior, women(400, 5), "standing", goal))
    assert (miss <= radii).mean() == pytest.approx(0.9, abs=0.03)


def test_each_quarter_has_its_part_and_the_test_set_none(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With validation and test women who are unlike the others, the file is still that of the others."""
    count = len(breast_skins(rig)[0].skin)
    known, used = women(40, 6, count), dict[str, set[int]]()

    def noted(name: str, made: object) -> object:
        def call(*given: object) -> object:
            used.setdefault(name, set()).update(
                each.number for part in given if isinstance(part, list) for each in part if isinstance(each, Woman)
            )
            return made(*given)

        return call

    monkeypatch.setattr(estimate, "read_women", lambda *_: tuple(known))
    for name in ("gaussian", "with_band", "misses"):
        monkeypatch.setattr(estimate, name, noted(name, getattr(estimate, name)))
    estimate.main(tmp_path, tmp_path / FILE)
    assert used["gaussian"] == {number for number in range(40) if number % 2 == 0}
    assert used["with_band"] == {number for number in range(40) if number % 4 == 1}
    written = json.loads((tmp_path / FILE).read_text())
    prior = with_band(gaussian(known[::2]), known[1::4], breast_skins(rig)[0].breast)
    way = replace(with_lying_mean(rig, prior.ways[0]), women=40)
    assert written == document(replace(prior, ways=(way, *gravity_prior(rig).ways[1:])))


def test_the_file_says_what_was_estimated(rig: Rig) -> None:
    """Read back: lengths to a twentieth of a millimetre, the numbers of the radii to their digits."""
    rng, count = np.random.default_rng(7), len(breast_skins(rig)[0].skin)
    mean = {name: rng.normal(0.0, 0.02, count * 3) for name in STANCES}
    factors = {name: rng.normal(0.0, 0.01, (3, count * 3)) for name in STANCES}
    prior = GravityPrior((Way(mean, factors, 0.043, 9),), band=2.345, posture=0.0125)
    read = gravity_prior(replace(rig, known={FILE: json.dumps(document(prior))}))
    assert (read.ways[0].observation, read.band, read.posture) == pytest.approx((0.043, 2.345, 0.0125))
    for name in STANCES:
        assert read.ways[0].mean[name] == pytest.approx(mean[name], abs=0.51 * TENTH)
        assert read.ways[0].factors[name] == pytest.approx(factors[name], abs=0.51 * TENTH)
        heights = mean[name].reshape(-1, 3) + 0.004
        for goal in {*STANCES} - {name}:
            for got, wanted in zip(read.moved(heights, name, goal), prior.moved(heights, name, goal), strict=True):
                assert got == pytest.approx(wanted, abs=5e-4)


def test_bodies_known_standing_and_lying_are_one_way_more(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The truth is the fit itself, laid down elsewhere and turned: each breast's motion, the right one mirrored."""
    skins, random = breast_skins(rig), np.random.default_rng(9)
    moves = np.zeros_like(rig.template)
    moves[skins[0].skin[skins[0].breast]] = [0.01, 0.02, -0.03]
    moves[skins[1].skin[skins[1].breast]] = [-0.01, 0.02, -0.03]
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    lying = (rig.template + posture(rig, "supine") + moves) @ turn.T + random.normal(size=3)
    scenes = [SimpleNamespace(truth=ClosestPointSearch(each, rig.faces)) for each in (rig.template, lying)]
    fit = SimpleNamespace(vertices=rig.template)
    left, right = two_stances.breasts(rig, fit, scenes)
    for each in (left, right):
        found = (each.heights["supine"] - each.heights["standing"]).reshape(-1, 3)
        assert found == pytest.approx(np.where(skins[0].breast[:, None], [0.01, 0.02, -0.03], 0.0), abs=2e-3)
    monkeypatch.setattr(two_stances, "women_in", lambda *_: iter([left, right]))
    two_stances.main([tmp_path], tmp_path / FILE)
    written = gravity_prior(replace(rig, known={FILE: (tmp_path / FILE).read_text()}))
    assert [way.women for way in written.ways] == [gravity_prior(rig).ways[0].women, 2]
    assert written.ways[1].mean.keys() == {"standing", "supine"}
