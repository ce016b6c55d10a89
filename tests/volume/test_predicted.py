"""What is predicted of a stance that was not scanned: the conditional Gaussian, and the rig's own data."""

import numpy as np
import pytest

from breastrig.core.errors import BadInput
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.predicted import (
    LEAST,
    STANCES,
    GravityPrior,
    Way,
    gravity_prior,
    in_standing_frame,
    posture,
    predicted,
    with_breasts,
)


def test_what_is_seen_in_one_stance_says_the_others_as_bayes_has_it() -> None:
    """Against the joint Gaussian's own conditional mean and covariance, written out."""
    rng = np.random.default_rng(5)
    factors = {name: rng.normal(size=(2, 6)) for name in STANCES}
    mean = {name: rng.normal(size=6) for name in STANCES}
    prior = GravityPrior((Way(mean, factors, 0.5, 9),), band=1.7, posture=0.0)
    seen = rng.normal(size=6)
    move, radii = prior.moved(seen.reshape(2, 3), "standing", "prone")
    stands, moves = factors["standing"], factors["prone"] - factors["standing"]
    gain = moves.T @ stands @ np.linalg.inv(stands.T @ stands + 0.25 * np.eye(6))
    wanted = mean["prone"] - mean["standing"] + gain @ (seen - mean["standing"])
    left = moves.T @ moves - gain @ stands.T @ moves
    assert move.ravel() == pytest.approx(wanted)
    assert radii == pytest.approx(1.7 * np.sqrt(np.diag(left).reshape(2, 3).sum(axis=1)))


def test_nine_of_ten_places_are_held_of_women_as_the_gaussian_has_them() -> None:
    """Drawn with her heights, which are seen with an error; a place whose deviation is shared by three axes."""
    rng = np.random.default_rng(6)
    factors = {name: rng.normal(0.0, 0.01, (40, 30)) for name in STANCES}
    mean = {name: rng.normal(0.0, 0.01, 30) for name in STANCES}
    prior = GravityPrior((Way(mean, factors, 0.01, 9),), band=1.45, posture=0.0)
    held = []
    for _ in range(300):
        z = rng.normal(size=40)
        seen, true = (mean[name] + z @ factors[name] for name in ("standing", "supine"))
        move, radii = prior.moved((seen + 0.01 * rng.normal(size=30)).reshape(-1, 3), "standing", "supine")
        held.append(np.linalg.norm(move - (true - seen).reshape(-1, 3), axis=1) <= radii)
    assert np.mean(held) == pytest.approx(0.9, abs=0.02)


def test_no_place_is_known_exactly() -> None:
    alike = {name: np.ones((1, 3)) for name in STANCES}
    prior = GravityPrior((Way({name: np.zeros(3) for name in STANCES}, alike, 0.06, 9),), band=2.0, posture=0.0)
    assert prior.moved(np.zeros((1, 3)), "standing", "prone")[1] == pytest.approx([2.0 * LEAST])


def test_ways_that_differ_are_met_halfway_and_their_distance_is_not_known() -> None:
    rng = np.random.default_rng(8)
    one, other = (
        Way(
            {name: rng.normal(size=6) for name in stances},
            {name: rng.normal(0.0, 0.3, (2, 6)) for name in stances},
            0.5,
            9,
        )
        for stances in (STANCES, STANCES[:2])
    )
    prior, seen = GravityPrior((one, other), band=1.7, posture=0.0), rng.normal(size=(2, 3))
    (first, of_first), (second, of_second) = (way.moved(seen, "standing", "supine") for way in (one, other))
    move, radii = prior.moved(seen, "standing", "supine")
    assert move == pytest.approx(0.5 * (first + second))
    apart = ((first - second) ** 2).sum(axis=1) / 4
    assert radii == pytest.approx(1.7 * np.sqrt(0.5 * (of_first + of_second) + apart))
    move, radii = prior.moved(seen, "standing", "prone")  # which one way alone knows
    assert move == pytest.approx(one.moved(seen, "standing", "prone")[0])
    assert radii == pytest.approx(1.7 * np.sqrt(one.moved(seen, "standing", "prone")[1]))


@pytest.mark.parametrize("goal", ["supine", "prone"])
def test_posture_and_breast_are_off_independently_and_each_side_by_its_own(goal: str, rig: Rig) -> None:
    prior = gravity_prior(rig)
    assert 0.001 < prior.posture < 0.05  # m
    skins = breast_skins(rig)
    within = [np.linspace(0.001, 0.03, len(skins[0].skin)), np.full(len(skins[1].skin), 0.2)]
    still = [np.zeros((len(each.skin), 3)) for each in skins]
    found = with_breasts(rig, rig.template, "standing", goal, list(zip(still, within, strict=True)))
    hanging = skin_map_settings(rig).error_hanging if goal == "prone" else 0.0
    assert (hanging > 0.01) == (goal == "prone")
    only = {side.side: np.setdiff1d(side.skin, other.skin) for side, other in (skins, skins[::-1])}
    for side, off in zip(skins, within, strict=True):
        here = np.isin(side.skin, only[side.side])
        assert found.radii[side.skin[here]] == pytest.approx(np.sqrt(prior.posture**2 + off[here] ** 2 + hanging**2))
    others = np.setdiff1d(np.arange(len(rig.template)), np.union1d(skins[0].skin, skins[1].skin))
    assert found.radii[others] == pytest.approx(prior.posture)


def test_a_mirrored_woman_has_mirrored_radii(rig: Rig) -> None:
    left, _ = breast_skins(rig)
    larger = rig.template.copy()
    larger[left.skin[left.breast]] += 0.5 * left.heights(larger)[left.breast]
    mirrored = larger[rig.mirror_vertices] * [-1.0, 1.0, 1.0]
    for goal in ("supine", "prone"):
        here, there = (predicted(rig, each, "standing", goal) for each in (larger, mirrored))
        assert there.radii == pytest.approx(here.radii[rig.mirror_vertices])
        assert there.vertices == pytest.approx(here.vertices[rig.mirror_vertices] * [-1.0, 1.0, 1.0], abs=1e-9)


def test_a_breast_that_moves_is_less_sure_than_the_chest_that_does_not(rig: Rig) -> None:
    """In the scan's metres: a few millimetres to a few centimetres, whatever the file's unit."""
    for goal in ("supine", "prone"):
        radii = predicted(rig, rig.template, "standing", goal).radii
        breast, notch = radii[rig.regions["areola_L"]], radii[rig.faces[rig.landmark_points(("xiphoid",)).faces]]
        assert 0.003 < notch.min() < breast.min()
        assert breast.max() < 0.06


def test_a_symmetric_body_stays_symmetric_and_its_trunk_stays(rig: Rig) -> None:
    lying = predicted(rig, rig.template, "standing", "supine")
    mirrored = lying.vertices[rig.mirror_vertices] * [-1.0, 1.0, 1.0]
    assert mirrored == pytest.approx(lying.vertices, abs=1e-9)
    assert lying.radii[rig.mirror_vertices] == pytest.approx(lying.radii)
    sternum = rig.landmark_points(("suprasternal_notch", "mid_sternum")).positions(
        lying.vertices - rig.template, rig.faces
    )
    assert np.linalg.norm(sternum, axis=1).max() < 0.012  # the notch of a raised collar goes down


def test_breasts_sink_when_lying_and_hang_when_prone(rig: Rig) -> None:
    left = rig.regions["areola_L"]
    supine, prone = (
        (predicted(rig, rig.template, "standing", goal).vertices - rig.template)[left].mean(axis=0)
        for goal in ("supine", "prone")
    )
    assert supine[0] > 0.003  # outwards
    assert supine[1] > 0.003  # up, for nothing pulls down any more
    assert supine[2] < -0.003
    assert prone[2] > 0.003


def test_no_breast_comes_to_a_side_that_has_none(rig: Rig) -> None:
    left, right = breast_skins(rig)
    flat = rig.template.copy()
    flat[left.skin[left.breast]] -= left.heights(flat)[left.breast]
    for goal in ("supine", "prone"):
        here, there = posture(rig, "standing"), posture(rig, goal)
        moved = predicted(rig, flat, "standing", goal).vertices - flat - there + here
        assert moved[left.skin] == pytest.approx(0.0, abs=1e-9)
        assert np.linalg.norm(moved[right.skin], axis=1).max() > 0.01


def test_a_turned_body_is_predicted_alike(rig: Rig) -> None:
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    here = predicted(rig, rig.template, "standing", "prone").vertices
    there = predicted(rig, rig.template @ turn.T + [1.0, 2.0, 3.0], "standing", "prone").vertices
    assert there == pytest.approx(here @ turn.T + [1.0, 2.0, 3.0], abs=1e-9)


def test_the_skin_joins_at_the_edge_of_the_breasts(rig: Rig) -> None:
    prior = gravity_prior(rig)
    left = breast_skins(rig)[0].skin
    rim = np.isin(left, rig.faces[~np.isin(rig.faces, left).all(axis=1)])
    for goal in ("supine", "prone"):
        heights = prior.ways[0].mean["standing"].reshape(-1, 3)
        move, _ = prior.moved(heights, "standing", goal)
        assert np.linalg.norm(move[rim], axis=1).max() < 3.5e-3


def test_a_trunk_that_lies_comes_back_to_how_it_stands(rig: Rig) -> None:
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    lying = (rig.template + posture(rig, "supine")) @ turn.T + [1.0, 2.0, 3.0]
    assert in_standing_frame(rig, lying, "supine") == pytest.approx(rig.template, abs=1e-9)


def test_what_is_not_known_is_said(rig: Rig) -> None:
    with pytest.raises(BadInput, match="standing already"):
        predicted(rig, rig.template, "standing", "standing")
