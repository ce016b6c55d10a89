"""Points carried between scans whose true correspondence is known."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, carried, spread_out, within_reach
from breastrig.geometry.normals import unit_vectors, vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig

TURN, SHIFT = exp_so3(np.array([1.2, -0.4, 0.3])), np.array([0.4, -0.2, 1.0])


def fitted_scan(rig: Rig, vertices: Array, stance: str = "standing") -> FittedScan:
    """A scan finer than the model, with the model exactly on it."""
    places = rig.landmark_points().positions(vertices, rig.faces)
    landmarks = dict(zip(rig.landmark_names, places, strict=True))
    return FittedScan(ScanTarget(*subdivided(vertices, rig.faces)), vertices, landmarks, stance)


def on_the_breasts(rig: Rig) -> Array:
    return np.unique(np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]]))


def lying(vertices: Array) -> Array:
    """A smooth change such as lying down makes: flatter, wider, the breasts a little up and outwards."""
    soft = 0.008 * np.exp(-(((vertices[:, 2] - vertices[:, 2].max()) / 0.08) ** 2))[:, None]
    return vertices * [1.03, 1.0, 0.96] + soft * np.stack(
        [np.tanh(vertices[:, 0] / 0.05), np.full(len(vertices), 0.7), np.zeros(len(vertices))], axis=1
    )


def errors(found: Array, true: Array) -> Array:
    return np.asarray(np.linalg.norm(found - true, axis=1))


def test_a_rigid_motion_carries_every_point_with_it_and_back(torso: Rig) -> None:
    a = fitted_scan(torso, torso.template)
    b = fitted_scan(torso, torso.template @ TURN.T + SHIFT)
    chosen = on_the_breasts(torso)
    way = SkinMap(torso, a, b)
    assert errors(way.to_b(a.vertices[chosen]), b.vertices[chosen]).max() < 1e-5
    assert errors(way.to_a(b.vertices[chosen]), a.vertices[chosen]).max() < 1e-5


def test_landmarks_that_colours_show_lead_the_way_as_picked_ones_do(torso: Rig) -> None:
    chosen = torso.template[on_the_breasts(torso)]
    picked = [fitted_scan(torso, torso.template), fitted_scan(torso, lying(torso.template), "supine")]
    seen = [replace(each, landmarks={}, seen=each.landmarks) for each in picked]
    neither = [replace(each, landmarks={}) for each in picked]
    np.testing.assert_array_equal(carried(torso, *seen, chosen), carried(torso, *picked, chosen))
    assert errors(carried(torso, *seen, chosen), carried(torso, *neither, chosen)).max() > 1e-4


@pytest.mark.parametrize("landmarks", [True, False])
def test_a_smooth_change_of_stance_is_followed_and_the_way_back_returns_the_point(landmarks: bool, torso: Rig) -> None:
    a = fitted_scan(torso, torso.template)
    b = fitted_scan(torso, lying(torso.template) @ TURN.T + SHIFT, "supine")
    if not landmarks:
        a, b = replace(a, landmarks={}), replace(b, landmarks={})
    chosen = on_the_breasts(torso)
    there = carried(torso, a, b, a.vertices[chosen])
    assert errors(there, b.vertices[chosen]).mean() < 1.5e-3
    assert b.target.search.query(there).distances.max() < 1e-9  # on the scan itself
    back, returned = np.split(carried(torso, b, a, np.concatenate([b.vertices[chosen], there])), 2)
    assert errors(back, a.vertices[chosen]).mean() < 1.5e-3
    assert errors(returned, a.vertices[chosen]).mean() < 0.5e-3


def test_landmarks_win_over_a_model_that_slid_along_the_skin(torso: Rig) -> None:
    a = fitted_scan(torso, torso.template)
    normals = vertex_normals(torso.template, torso.faces)
    slide = np.array([0.0, 0.012, 0.0]) - 0.012 * normals[:, [1]] * normals
    slid = a.target.search.query(torso.template + slide).points
    b = replace(a, vertices=slid)
    chosen = on_the_breasts(torso)
    true = a.vertices[chosen]
    assert errors(slid[chosen], true).mean() > 6e-3  # what the model alone would answer
    assert errors(carried(torso, a, b, true), true).mean() < 2e-3


def test_a_model_that_is_not_on_its_scan_is_refused(torso: Rig) -> None:
    a = fitted_scan(torso, torso.template)
    for pair in ((replace(a, vertices=a.vertices + 1.0), a), (a, replace(a, vertices=a.vertices + 1.0))):
        with pytest.raises(BadDrawing, match=r"does not lie on its scan; .*\."):
            SkinMap(torso, *pair)


def test_spread_out_points_are_far_from_each_other() -> None:
    line = np.linspace(0.0, 1.0, 101)[:, None] * [1.0, 0.0, 0.0]
    assert sorted(line[spread_out(line, 3)][:, 0]) == [0.0, 0.5, 1.0]
    assert len(spread_out(line, 500)) == 101


def test_skin_is_followed_as_far_from_the_left_breast_as_from_the_right_and_between_them(torso: Rig) -> None:
    vertices = torso.template @ TURN.T + SHIFT
    left, right = (vertices[torso.regions[f"breast_{side}"]].mean(axis=0) for side in "LR")
    outwards, up = unit_vectors(np.array([left - right, np.cross(TURN[:, 2], left - right)]))
    near, far = (skin_map_settings(torso).reach + gap for gap in (-1e-3, 1e-3))
    ways = ((left, outwards), (right, -outwards), (left, up), (right, -up), (0.5 * (left + right), up))
    points = np.array([start + away * way for start, way in ways for away in (near, far)])
    assert within_reach(torso, vertices, points).tolist() == [True, False] * len(ways)
    for kept in ("breast_L", "breast_R"):  # of one breast alone the middle of the chest is not known
        assert within_reach(replace(torso, regions={kept: torso.regions[kept]}), vertices, points).all()
