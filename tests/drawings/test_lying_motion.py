"""What is expected of the skin of somebody who lies down: data, mirrored, smooth, and only there where it is known."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from helpers.subdivide import subdivided

from breastrig.core.arrays import Array, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.skin_maps.lying_motion import BEYOND, Motions, lying_motion
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, carried
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig_studies.lying_motion import agreed, differing

TURN, SHIFT = exp_so3(np.array([1.2, -0.4, 0.3])), np.array([0.4, -0.2, 1.0])


def known(rig: Rig) -> Array:
    moves = lying_motion(rig)
    return np.asarray(moves[0])


def on_both_breasts(rig: Rig) -> Integers:
    return np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]])


def fitted_scan(rig: Rig, vertices: Array, stance: str) -> FittedScan:
    return FittedScan(ScanTarget(*subdivided(vertices, rig.faces)), vertices, {}, stance)


def test_both_sides_move_alike_and_the_back_not_at_all(torso: Rig) -> None:
    moves = known(torso)
    np.testing.assert_allclose(moves[torso.mirror_vertices] * [-1.0, 1.0, 1.0], moves, atol=0.3e-3)
    assert np.linalg.norm(moves, axis=1).max() < 0.02
    behind = torso.template[:, 2] < -0.05
    assert np.linalg.norm(moves[behind], axis=1).max() < 1e-4


def test_breasts_sink_outwards(torso: Rig) -> None:
    moves = known(torso)
    assert moves[torso.regions["breast_L"], 0].mean() > 1e-3
    assert moves[torso.regions["breast_R"], 0].mean() < -1e-3


def test_the_motion_is_met_at_its_places_and_dies_out_beyond_them() -> None:
    """The second motion is one that the sides do in reverse."""
    motion = Motions(np.array([[0.1, 0.0, 0.0]]), np.tile([0.01, 0.002, 0.0], (2, 1, 1)), np.array([1.0, -1.0]))
    there = motion.at(np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.3, 0.0, 0.0]]))
    left, right = np.array([0.01, 0.002, 0.0]), np.array([-0.01, 0.002, 0.0])
    np.testing.assert_allclose(there, [[left, right, 0.0 * left], [left, -right, 0.0 * left]], atol=1e-12)
    assert 0.0 < BEYOND < 1.0


def test_another_rig_is_not_expected_to_move(torso: Rig) -> None:
    assert lying_motion(replace(torso, known={})) is None


def test_skin_that_moves_as_in_everybody_is_carried_without_any_landmark(torso: Rig) -> None:
    """Up and down, on bodies turned in space; and with landmarks nothing is expected of one who stands twice."""
    lying = (torso.template + known(torso)) @ TURN.T + SHIFT
    a, b = fitted_scan(torso, torso.template, "standing"), fitted_scan(torso, lying, "supine")
    chosen = on_both_breasts(torso)
    way = SkinMap(torso, a, b)
    down = np.linalg.norm(way.to_b(torso.template[chosen]) - lying[chosen], axis=1)
    up = np.linalg.norm(way.to_a(lying[chosen]) - torso.template[chosen], axis=1)
    plain = SkinMap(torso, a, replace(b, stance="standing"))
    without = np.linalg.norm(plain.to_b(torso.template[chosen]) - lying[chosen], axis=1)
    assert down.mean() < 0.5e-3
    assert up.mean() < 0.5e-3
    assert without.mean() > 2.0 * down.mean()


@pytest.mark.parametrize("way", [2])
def test_a_woman_who_differs_is_carried_by_the_way_in_which_she_does(way: int, torso: Rig) -> None:
    """By two standard deviations, in one of the three ways in which women differ most; her nipples alone are known."""
    moves = lying_motion(torso)
    a = fitted_scan(torso, torso.template, "standing")
    b = fitted_scan(torso, (torso.template + moves[0] + 2.0 * moves[1 + way]) @ TURN.T + SHIFT, "supine")
    points = torso.landmark_points(("nipple_L", "nipple_R"))
    a, b = (
        replace(each, landmarks=dict(zip("lr", points.positions(each.vertices, torso.faces), strict=True)))
        for each in (a, b)
    )
    chosen = on_both_breasts(torso)
    carried_by, mean = (
        np.linalg.norm(SkinMap(torso, a, b, motion=motion).to_b(a.vertices[chosen]) - b.vertices[chosen], axis=1).mean()
        for motion in (moves, moves[:1])
    )
    assert carried_by < 2e-3
    assert carried_by < 0.5 * mean


def test_ways_agree_as_far_as_the_smaller_one_goes() -> None:
    ways = [np.array([[0.004, -0.002, 0.001]]), np.array([[0.001, -0.005, -0.001]])]
    np.testing.assert_array_equal(agreed(ways), [[0.001, -0.002, 0.0]])


def test_ways_in_which_women_differ_are_found_with_their_size(torso: Rig) -> None:
    """Of four women: one motion twice forwards or backwards, a fifth of it more on one side than on the other."""
    moves, seen = known(torso), np.ones(len(torso.template), dtype=np.bool_)
    left = np.where(torso.template[:, :1] > 0.0, 0.2, -0.2) * moves
    found = differing(torso, [[(size * moves + way * left, seen)] for size, way in product((-2.0, 2.0), (-1.0, 1.0))])
    assert found.signs[:2].tolist() == [1, -1]
    sizes = np.linalg.norm(found.moves, axis=(1, 2))
    assert sizes[1] == pytest.approx(0.1 * sizes[0], rel=0.2)
    assert sizes[2] < 0.02 * sizes[0]  # the template is not its own mirror image to the last digit
    there, chosen = found.at(torso.template)[0], on_both_breasts(torso)
    there *= np.sign(np.vdot(there, moves))
    off, size = (np.linalg.norm(each[chosen], axis=1).mean() for each in (there - 2.0 * moves, 2.0 * moves))
    assert off < 0.2 * size  # blended twice


def test_a_plan_is_carried_up_by_the_inverse_of_the_way_down(torso: Rig) -> None:
    """From lying to standing the mean motion is gone backwards, exactly, and is not left out."""
    lying = (torso.template + known(torso)) @ TURN.T + SHIFT
    a, b = fitted_scan(torso, torso.template, "standing"), fitted_scan(torso, lying, "supine")
    chosen = on_both_breasts(torso)
    way = SkinMap(torso, a, b)
    np.testing.assert_allclose(way.moved(way.moved_back(lying[chosen])), lying[chosen], atol=1e-5)
    up, left_out = carried(torso, b, a, lying[chosen]), SkinMap(torso, b, a).to_b(lying[chosen])
    np.testing.assert_array_equal(up, way.to_a(lying[chosen]))
    wrong = np.linalg.norm(left_out - torso.template[chosen], axis=1).mean()
    assert np.linalg.norm(up - torso.template[chosen], axis=1).mean() < 0.5 * wrong
