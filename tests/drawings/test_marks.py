"""Marks that two scans share: they lead the map, a wrong one is named, and lines are surer near them."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.skin_maps.marks import left_over
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, carried, shared_marks, spread_out
from breastrig.drawings.transfer import transferred
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig

Pair = tuple[FittedScan, FittedScan]


def on_the_breasts(rig: Rig) -> Array:
    return np.unique(np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]]))


def slid(vertices: Array) -> Array:
    """The breasts' skin up by 20 mm, as no landmark shows."""
    return vertices + 0.02 * np.exp(-(((vertices[:, 2] - vertices[:, 2].max()) / 0.06) ** 2))[:, None] * [0.0, 1.0, 0.0]


@pytest.fixture(scope="module")
def pair(torso: Rig) -> Pair:
    """A scan, and one on which the skin of the breasts has slid; both models lie on them as if it had not."""
    radii = np.full(len(torso.template), 0.010)
    there = ScanTarget(*subdivided(slid(torso.template), torso.faces))
    return (
        FittedScan(ScanTarget(*subdivided(torso.template, torso.faces)), torso.template, {}, "standing", radii),
        FittedScan(there, there.search.query(torso.template).points, {}, "standing", radii),
    )


@pytest.fixture(scope="module")
def points(torso: Rig) -> Array:
    """(8, 3) m far from each other on the breasts of the first scan."""
    breasts = torso.template[on_the_breasts(torso)]
    return breasts[spread_out(breasts, 8)]


def marked(pair: Pair, points: Array, wrong: Array | None = None) -> Pair:
    here = {f"dot {k}": place for k, place in enumerate(points)}
    height = 0.02 * np.exp(-(((points[:, 2] - pair[0].vertices[:, 2].max()) / 0.06) ** 2))
    there = dict(zip(here, points + height[:, None] * [0.0, 1.0, 0.0], strict=True))
    there |= {} if wrong is None else {"dot 3": wrong}
    return replace(pair[0], marks=here), replace(pair[1], marks=there)


def with_marks_there(pair: Pair) -> Array:
    """(8, 3) m of the marks on the second scan."""
    return np.array(list(pair[1].marks.values()))


def errors(rig: Rig, pair: Pair, points: Array, true: Array) -> Array:
    return np.asarray(np.linalg.norm(carried(rig, *pair, points) - true, axis=1))


def test_marks_lead_the_map_where_landmarks_are_missing(torso: Rig, pair: Pair, points: Array) -> None:
    breasts = torso.template[on_the_breasts(torso)]
    true = slid(torso.template)[on_the_breasts(torso)]
    with_marks = marked(pair, points)
    without, found = errors(torso, pair, breasts, true), errors(torso, with_marks, breasts, true)
    assert found.mean() < 0.5 * without.mean()
    assert errors(torso, with_marks, points, with_marks_there(with_marks)).max() < 3e-3
    assert shared_marks(torso, *with_marks).followed == tuple(with_marks[0].marks)


def test_marks_that_only_one_scan_has_change_nothing_at_all(torso: Rig, pair: Pair, points: Array) -> None:
    lone = replace(pair[0], marks={"here": points[0]}), replace(pair[1], marks={"there": points[1]})
    np.testing.assert_array_equal(carried(torso, *lone, points), carried(torso, *pair, points))
    both = marked(pair, points)
    np.testing.assert_array_equal(SkinMap(torso, *both, marks=False).moved(points), SkinMap(torso, *pair).moved(points))


def test_a_wrong_pair_is_named_and_not_followed(torso: Rig, pair: Pair, points: Array) -> None:
    true = with_marks_there(marked(pair, points))[3]
    towards = pair[1].target.search.query((true + np.array([0.0, 0.03, 0.03]))[None]).points[0] - true
    wrong = pair[1].target.search.query((true + 0.04 / np.linalg.norm(towards) * towards)[None]).points[0]
    with_wrong = marked(pair, points, wrong)
    found = shared_marks(torso, *with_wrong)
    [(name, off)] = found.asked
    assert name == "dot 3"
    assert 0.02 < off < 0.06
    assert found.followed == tuple(name for name in with_wrong[0].marks if name != "dot 3")
    right = [replace(each, marks={n: at for n, at in each.marks.items() if n != "dot 3"}) for each in with_wrong]
    np.testing.assert_array_equal(carried(torso, *with_wrong, points), carried(torso, right[0], right[1], points))
    assert shared_marks(torso, with_wrong[1], with_wrong[0]) == found


def test_two_exchanged_names_are_both_asked_about(torso: Rig, pair: Pair, points: Array) -> None:
    a, b = marked(pair, points)
    exchanged = b.marks | {"dot 0": b.marks["dot 1"], "dot 1": b.marks["dot 0"]}
    found = shared_marks(torso, a, replace(b, marks=exchanged))
    assert {name for name, _ in found.asked} == {"dot 0", "dot 1"}


def test_lines_are_surer_near_marks_and_as_sure_as_before_far_away(torso: Rig, pair: Pair, points: Array) -> None:
    settings, spread = skin_map_settings(torso), np.array([0.005])
    away = points[:1] + np.array([[0.0, distance, 0.0] for distance in (0.0, 0.02, 0.05, 0.1, 1.0)])
    left = left_over(away, points[:1], spread, settings)
    assert (np.diff(left) > 0.0).all()
    assert left[-1] == pytest.approx(1.0, abs=1e-6)
    share, noise = settings.mark_share, settings.mark_error**2
    assert left[0] == pytest.approx(1.0 - share**2 / (1.0 + noise / spread[0] ** 2))
    with_marks = marked(pair, points)
    there, names = with_marks_there(with_marks), tuple(with_marks[0].marks)
    plain = carried_errors(torso, *with_marks, points, there)
    near = carried_errors(torso, *with_marks, points, there, marks=names)
    line = Polyline("line", False, "#000000", points[:2], np.zeros(2, dtype=np.bool_))
    [found] = transferred(torso, *with_marks, [line])
    assert plain is not None
    assert near is not None
    assert (near < 0.8 * plain).all()
    assert found.line.error is not None
    assert found.line.error[0] == pytest.approx(near[0], rel=0.05)


def test_marks_narrow_nothing_of_a_prediction(torso: Rig, pair: Pair, points: Array) -> None:
    a, b = marked(pair, points)
    found = carried_errors(torso, a, replace(b, predicted=True), points, with_marks_there((a, b)), marks=tuple(a.marks))
    assert found is not None
    assert found.min() > 0.010
