"""What is predicted of a stance that was not scanned: the conditional Gaussian, and the rig's own data."""

import numpy as np
import pytest

from breastrig.core.errors import BadInput
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.predicted import STANCES, GravityPrior, gravity_prior, posture, predicted, stood_up


@pytest.fixture(scope="module")
def rig() -> Rig:
    return read_rig(default_rig_path())


def test_what_is_seen_in_one_stance_says_the_others_as_bayes_has_it() -> None:
    """Against the joint Gaussian's own conditional mean and covariance, written out."""
    rng = np.random.default_rng(5)
    factors = {name: rng.normal(size=(2, 6)) for name in STANCES}
    mean = {name: rng.normal(size=6) for name in STANCES}
    prior = GravityPrior(mean, factors, observation=0.5, band=1.0, posture=0.0)
    seen = rng.normal(size=6)
    move, radii = prior.moved(seen.reshape(2, 3), "standing", "prone")
    stands, moves = factors["standing"], factors["prone"] - factors["standing"]
    gain = moves.T @ stands @ np.linalg.inv(stands.T @ stands + 0.25 * np.eye(6))
    wanted = mean["prone"] - mean["standing"] + gain @ (seen - mean["standing"])
    left = moves.T @ moves - gain @ stands.T @ moves
    assert move.ravel() == pytest.approx(wanted)
    assert radii == pytest.approx(np.sqrt(np.diag(left).reshape(2, 3).sum(axis=1)))


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
    assert prior is not None
    left = breast_skins(rig)[0].skin
    rim = np.isin(left, rig.faces[~np.isin(rig.faces, left).all(axis=1)])
    for goal in ("supine", "prone"):
        move = (prior.mean[goal] - prior.mean["standing"]).reshape(-1, 3)
        assert np.linalg.norm(move[rim], axis=1).max() < 3.5e-3


def test_a_trunk_that_lies_comes_back_to_how_it_stands(rig: Rig) -> None:
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    lying = (rig.template + posture(rig, "supine")) @ turn.T + [1.0, 2.0, 3.0]
    assert stood_up(rig, lying, "supine") == pytest.approx(rig.template, abs=1e-9)


def test_what_is_not_known_is_said(rig: Rig) -> None:
    with pytest.raises(BadInput, match="standing already"):
        predicted(rig, rig.template, "standing", "standing")
