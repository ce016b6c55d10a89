"""Tissue carried between stances where its way is known."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided
from helpers.surfaces import sphere
from helpers.walled_patient import hanging

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.inks import LESION
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanLesion
from breastrig.drawings.skin_maps.interior_map import moved_inside, over
from breastrig.drawings.skin_maps.lying_motion import lying_motion
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig

TURN, SHIFT = exp_so3(np.array([0.7, -0.4, 1.3])), np.array([0.3, -0.2, 0.5])
INSIDE = np.array([[0.0, 0.0, 0.0], [0.03, 0.01, 0.02], [-0.02, 0.05, -0.04]])


def moved(points: Array) -> Array:
    return np.asarray(points @ TURN.T + SHIFT)


def pressed(points: Array) -> Array:
    """Flatter by a tenth and wider by as much as keeps the volume."""
    return np.asarray(points * np.array([0.9**-0.5, 0.9**-0.5, 0.9]))


@pytest.fixture(scope="module")
def ball(toy_rig: Rig) -> Rig:
    vertices, faces = sphere(subdivisions=3)
    return replace(toy_rig, template=vertices, faces=faces, regions={})


def fitted(rig: Rig, vertices: Array, stance: str = "standing", radius: float | None = None) -> FittedScan:
    radii = None if radius is None else np.full(len(vertices), radius)
    return FittedScan(ScanTarget(vertices, rig.faces), vertices, {}, stance, radii)


@pytest.mark.parametrize("stances", [("supine", "standing"), ("standing", "standing")])
def test_what_is_inside_moves_with_a_rigid_body(ball: Rig, stances: tuple[str, str]) -> None:
    a, b = fitted(ball, ball.template, stances[0]), fitted(ball, moved(ball.template), stances[1])
    there = moved_inside(ball, a, b, INSIDE)
    np.testing.assert_allclose(there, moved(INSIDE), atol=1e-6)


def test_what_is_inside_follows_a_body_that_is_pressed_flat_and_comes_back(ball: Rig) -> None:
    a, b = fitted(ball, ball.template), fitted(ball, pressed(ball.template), "supine")
    there = moved_inside(ball, a, b, INSIDE)
    assert (
        np.linalg.norm(there - pressed(INSIDE), axis=1).max()
        < 0.25 * np.linalg.norm(INSIDE - pressed(INSIDE), axis=1).max()
    )
    back = moved_inside(ball, b, a, there)
    np.testing.assert_allclose(back, INSIDE, atol=2e-4)


def scanned(rig: Rig, vertices: Array, stance: str, landmarks: bool) -> FittedScan:
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(vertices, rig.faces), strict=True))
    return FittedScan(ScanTarget(*subdivided(vertices, rig.faces)), vertices, places if landmarks else {}, stance)


def inside_the_breasts(rig: Rig, vertices: Array) -> Array:
    """(2, 3) m, left and right."""
    return np.array([vertices[rig.regions[f"breast_{side}"]].mean(axis=0) for side in "LR"])


def test_tissue_of_the_breasts_follows_the_skin_and_that_of_an_arm_the_fit(torso: Rig) -> None:
    """The landmarks know that the fit slid along the skin; of an arm that was raised the fit alone knows."""
    torso = replace(torso, known={"skin_map.toml": "reach = 0.1\n"})
    places, weight = torso.template, np.zeros(len(torso.template))
    arm, shoulder = torso.regions["arm_R"], places[torso.regions["arm_R"]].max(axis=0)
    weight[arm] = np.clip((shoulder[1] - places[arm, 1]) / 0.1, 0.0, 1.0)
    turn = exp_so3(np.array([0.0, 0.0, -0.3])).T - np.eye(3)
    raised = places + (weight[:, None] * (places - shoulder)) @ turn
    a, b = scanned(torso, torso.template, "standing", True), scanned(torso, raised, "standing", True)
    normals = vertex_normals(raised, torso.faces)
    slide = np.array([0.0, 0.012, 0.0]) - 0.012 * normals[:, [1]] * normals
    slide[weight > 0.0] = 0.0
    b = replace(b, vertices=b.target.search.query(raised + slide).points)
    beyond = arm[places[arm, 0] < -0.21]
    breasts = inside_the_breasts(torso, places)
    found = moved_inside(torso, a, b, np.array([*breasts, places[beyond].mean(axis=0)]))
    assert np.linalg.norm(inside_the_breasts(torso, b.vertices) - breasts, axis=1).min() > 5e-3
    assert np.linalg.norm(found[:2] - breasts, axis=1).max() < 3e-3
    assert np.linalg.norm((raised - places)[beyond].mean(axis=0)) > 0.02
    assert np.linalg.norm(found[2] - raised[beyond].mean(axis=0)) < 6e-3


def test_tissue_sinks_outwards_on_both_sides_and_comes_back_the_same_way(torso: Rig) -> None:
    motions = lying_motion(torso)
    motion = motions[0]
    a = scanned(torso, torso.template, "standing", False)
    b = scanned(torso, moved(torso.template + motion), "supine", False)
    breasts = inside_the_breasts(torso, torso.template)
    there = moved_inside(torso, a, b, breasts)
    left, right = (there - SHIFT) @ TURN - breasts
    np.testing.assert_allclose(right, left * [-1.0, 1.0, 1.0], atol=2e-4)
    assert left[0] > 1e-3  # both sink outwards
    skin = torso.template[torso.regions["breast_R"]]
    on_skin = SkinMap(torso, a, b, ways=False).moved(skin)
    back = moved_inside(torso, b, a, np.concatenate([there, on_skin]))
    np.testing.assert_allclose(back[:2], breasts, atol=8e-4)
    np.testing.assert_allclose(back[2:], skin, atol=1e-6)


def test_tissue_on_a_chest_wall_that_is_seen_goes_with_the_breastbone_and_the_rest_as_without(torso: Rig) -> None:
    a = scanned(torso, hanging(torso), "prone", True)
    b = scanned(torso, moved(torso.template), "supine", True)
    middle = inside_the_breasts(torso, torso.template)[0]
    height = middle[2] + 0.01
    corners = np.array([[-0.3, 0.0, height], [0.3, 0.0, height], [0.3, 0.7, height], [-0.3, 0.7, height]])
    wall = ClosestPointSearch(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    rising = middle * [1.0, 1.0, 0.0] + np.array([0.0, 0.0, 1.0]) * (height + np.array([[-0.005, 0.0, 0.008, 0.2]]).T)
    free = moved_inside(torso, a, b, rising)
    fast = moved_inside(torso, replace(a, wall=wall), b, rising)
    np.testing.assert_allclose(fast[:2], moved(rising[:2]), atol=1e-3)  # on the wall and behind it: with the bone
    assert np.linalg.norm(free - moved(rising), axis=1)[:2].min() > 3e-3
    np.testing.assert_allclose(fast[2], free[2] + np.exp(-1.0) * (moved(rising)[2] - free[2]), atol=1e-3)
    np.testing.assert_allclose(fast[3], free[3], atol=1e-6)


def test_beside_a_wall_that_ends_tissue_goes_as_without_and_the_more_so_the_farther_away(torso: Rig) -> None:
    """Behind the plane of a wall that another breast has: nobody has seen a wall there."""
    a = scanned(torso, hanging(torso), "prone", True)
    b = scanned(torso, moved(torso.template), "supine", True)
    left, right = inside_the_breasts(torso, torso.template)
    corners = np.array([[x, y, left[2]] for x, y in ((0.0, 0.0), (0.3, 0.0), (0.3, 0.7), (0.0, 0.7))])
    wall = ClosestPointSearch(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    behind = np.array([left, right, right * [0.0, 1.0, 1.0] - [0.004, 0.0, 0.0]]) - [0.0, 0.0, 0.003]
    np.testing.assert_allclose(over(wall, behind), [0.0, np.hypot(right[0], 0.003), 0.005], atol=1e-9)
    free, held = moved_inside(torso, a, b, behind), moved_inside(torso, replace(a, wall=wall), b, behind)
    share = np.linalg.norm(held - free, axis=1) / np.linalg.norm(moved(behind) - free, axis=1)
    assert share == pytest.approx([1.0, 0.0, np.exp(-5.0 / 8.0)], abs=0.08)


def test_a_rig_that_has_no_breastbone_carries_as_if_no_wall_were_seen(ball: Rig) -> None:
    a, b = fitted(ball, ball.template, "prone"), fitted(ball, pressed(ball.template), "supine")
    seen = replace(a, wall=ClosestPointSearch(0.5 * ball.template, ball.faces))
    np.testing.assert_array_equal(moved_inside(ball, seen, b, INSIDE), moved_inside(ball, a, b, INSIDE))


def lesion(name: str, center: list[float], scan: str = "") -> PlanLesion:
    return PlanLesion(id=name, scan=scan, name=name, center=center, radius_mm=8.0)


def test_a_plan_carries_its_lesions_and_draws_each_on_the_skin_next_to_it(ball: Rig) -> None:
    a, b = fitted(ball, ball.template), fitted(ball, moved(ball.template))
    near, far = lesion("near", [0.0, 80.0, 0.0]), lesion("far", [300.0, 0.0, 0.0])
    own = lesion("own", [float(1e3 * value) for value in moved(np.array([[0.0, 0.0, 0.07]]))[0]])
    here, other = PlannedScan("supine", b, [own]), PlannedScan("standing", a, [near, far])
    found = plan_on_scan(ball, here, [other])
    places = {each.item.id: each for each in found.lesions}
    assert places.keys() == {"own", "near"}
    np.testing.assert_allclose(places["near"].center, moved(np.array([[0.0, 0.08, 0.0]]))[0], atol=1e-5)
    assert (places["near"].is_carried, places["own"].is_carried) == (True, False)
    assert (places["near"].error, places["own"].error) == (None, 0.0)
    assert places["near"].depth == pytest.approx(0.02, abs=5e-4)
    (missing,) = found.missing
    assert (missing.item.id, missing.reason) == (
        "far",
        "far comes to lie 200 mm outside the skin; check its frame and unit.",
    )
    for line in found.lines:
        assert (line.line.closed, line.line.color, line.part) == (True, LESION, "projection")
        (nearest,) = b.target.search.query(places[line.item.id].center[None]).points
        gaps = np.linalg.norm(line.line.points - nearest, axis=1)
        np.testing.assert_allclose(gaps, 0.008, atol=2e-4)


def test_a_lesion_a_little_over_the_skin_is_shown_and_one_farther_out_is_not(ball: Rig) -> None:
    a = fitted(ball, ball.template)
    items = [lesion("over", [0.0, 108.0, 0.0]), lesion("beyond", [0.0, 0.0, -112.0])]
    found = plan_on_scan(ball, PlannedScan("standing", a, items), [])
    assert [(each.item.id, each.is_carried) for each in found.lesions] == [("over", False)]
    assert found.lesions[0].depth == pytest.approx(-0.008, abs=5e-4)
    assert [(each.item.id, each.reason) for each in found.missing] == [
        ("beyond", "beyond lies 12 mm outside the skin; check its frame and unit.")
    ]


def test_the_radius_of_each_is_what_both_fits_leave_open_at_its_own_place(ball: Rig) -> None:
    calibrated = replace(ball, known={"skin_map.toml": "error_skin = 0.003\nerror_share = 0.5\n"})
    high, left = ball.template[:, 1], ball.template[:, 0]
    a = replace(fitted(ball, ball.template), radii=0.004 + 0.02 * (0.1 + high))
    b = replace(fitted(ball, moved(ball.template), "supine"), radii=0.003 + 0.03 * (0.1 + left))
    items = [lesion("above", [0.0, 80.0, 0.0]), lesion("aside", [80.0, 0.0, 0.0])]
    found = plan_on_scan(calibrated, PlannedScan("supine", b, []), [PlannedScan("standing", a, items)]).lesions
    expected = [np.linalg.norm([0.003, 0.5 * here, 0.5 * there]) for here, there in ((0.008, 0.006), (0.006, 0.009))]
    assert [each.error for each in found] == pytest.approx(expected, abs=1e-4)
