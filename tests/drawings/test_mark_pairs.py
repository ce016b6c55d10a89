"""Pairs of small marks: the right ones, whatever their order; none where another one is as good."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.marks.mark_pairs import SmallMarks, followed, paired
from breastrig.drawings.skin_maps.skin_map import FittedScan, spread_out
from breastrig.rig.model import Rig

MOLE, DOT = (-25.0, 2.0, 3.0), (-20.0, 10.0, -30.0)


def marks(places: Array, colours: Array | None = None) -> SmallMarks:
    colours = np.tile(MOLE, (len(places), 1)) if colours is None else colours
    return SmallMarks(places, np.full(len(places), 4e-3), colours)


@pytest.fixture(scope="module")
def scan(torso: Rig) -> FittedScan:
    target = ScanTarget(*subdivided(torso.template, torso.faces))
    return FittedScan(target, torso.template, {}, "standing", np.full(len(torso.template), 0.010))


@pytest.fixture(scope="module")
def places(torso: Rig) -> Array:
    """(9, 3) m on the breasts, far from each other and from the nipples."""
    breasts = torso.template[np.concatenate([torso.regions["breast_L"], torso.regions["breast_R"]])]
    nipples = torso.landmark_points(("nipple_L", "nipple_R")).positions(torso.template, torso.faces)
    far = breasts[(np.linalg.norm(breasts[:, None] - nipples, axis=2) > 0.03).all(axis=1)]
    return far[spread_out(far, 9)]


def test_marks_are_paired_whatever_their_order_and_the_rest_is_left(
    torso: Rig, scan: FittedScan, places: Array
) -> None:
    order = np.random.default_rng(3).permutation(8)
    found = paired(torso, scan, replace(scan), marks(places), marks(places[order]))
    assert sorted((pair.here, order[pair.there]) for pair in found) == [(k, k) for k in range(8)]
    assert all(pair.off < 1e-3 < pair.error for pair in found)


def test_of_two_that_look_alike_none_is_proposed_until_colours_tell(
    torso: Rig, scan: FittedScan, places: Array
) -> None:
    twins = scan.target.search.query(np.stack([places[0], places[0] + [0.0, 0.006, 0.0]])).points
    assert paired(torso, scan, replace(scan), marks(places[:1]), marks(twins)) == ()
    [pair] = paired(torso, scan, replace(scan), marks(places[:1]), marks(twins, np.array([DOT, MOLE])))
    assert (pair.here, pair.there) == (0, 1)


def test_what_contradicts_the_others_is_dropped(torso: Rig, scan: FittedScan, places: Array) -> None:
    there = places.copy()
    there[0] = scan.target.search.query((places[0] + [0.0, 0.035, 0.0])[None]).points[0]
    unsure = replace(scan, radii=np.full(len(torso.template), 0.03))
    found = paired(torso, unsure, replace(unsure), marks(places), marks(there))
    assert {pair.here for pair in found} == set(range(1, 9))


def test_nipples_known_marks_and_skin_far_away_are_left_out(torso: Rig, scan: FittedScan, places: Array) -> None:
    nipple = torso.landmark_points(("nipple_L",)).positions(torso.template, torso.faces)[0]
    head = torso.template[torso.template[:, 1].argmax()]
    asked = marks(np.stack([places[0], nipple, head, places[1], nipple + 0.03]))
    known = replace(scan, marks={"m1": places[1]})
    assert followed(torso, known, asked).tolist() == [True, False, False, False, False]
