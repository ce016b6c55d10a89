"""Smooth modes of the built model: a Gaussian process about the breasts' landmarks, alike on both sides."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.rig.model import Rig
from breastrig.rig.modes import mode_count, mode_sizes, with_modes
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose

OVER = np.array([-1.0, 1.0, 1.0])


def moves_of(rig: Rig) -> np.ndarray:
    """(K, V, 3) m."""
    return with_modes(rig).blendshapes[len(rig.shapes) :]


@pytest.mark.parametrize("name", ["nipple_L", "inframammary_fold_R"])
def test_skin_deviates_as_far_as_is_said_along_and_across(torso: Rig, name: str) -> None:
    sizes, points = mode_sizes(torso), torso.landmark_points((name,))
    assert sizes is not None
    moved = np.array([points.positions(each, torso.faces)[0] for each in moves_of(torso)])  # (K, 3)
    deviations = np.sqrt(np.linalg.eigvalsh(moved.T @ moved))
    np.testing.assert_allclose(deviations, [sizes.across, sizes.along, sizes.along], rtol=0.06)


def test_landmarks_over_bones_hold_the_bones(torso: Rig) -> None:
    names = tuple(n for n in torso.landmark_names if n.split("_")[0] in ("suprasternal", "acromion", "umbilicus"))
    moved = [torso.landmark_points(names).positions(each, torso.faces) for each in moves_of(torso)]
    assert np.sqrt(np.square(moved).sum(axis=(0, 2))).max() < 2e-4


def test_a_mode_and_its_partner_are_mirrored(torso: Rig) -> None:
    rig, moves = with_modes(torso), moves_of(torso)
    names = [shape.name for shape in rig.shapes[len(torso.shapes) :]]
    partners = [names.index(shape.mirror) for shape in rig.shapes[len(torso.shapes) :]]
    assert sorted(partners) == list(range(mode_count(torso)))
    apart = moves[partners][:, torso.mirror_vertices] * OVER - moves
    assert np.abs(apart).max() < 0.03 * np.abs(moves).max()  # the template itself is symmetric to that


def test_the_skin_is_that_of_the_modes_and_without_them_that_of_the_shapes(torso: Rig) -> None:
    rest = rest_parameters(torso)
    weights = np.random.default_rng(1).normal(size=mode_count(torso))
    x = replace(rest, modes=weights)
    expected = torso.template + np.einsum("k,kvi->vi", weights, moves_of(torso))
    np.testing.assert_allclose(pose(torso, x), expected, atol=1e-12)
    np.testing.assert_array_equal(pose(torso, x.without_modes), pose(torso, rest))


def test_a_rig_of_which_nothing_is_known_has_none(torso: Rig) -> None:
    bare = replace(torso, known={})
    assert mode_count(bare) == 0
    assert with_modes(bare) is bare
