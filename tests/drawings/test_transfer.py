"""Drawings carried between surfaces where the answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided
from helpers.surfaces import plane, sphere

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadDrawing
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.drawings.transfer import transferred
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.scan.clean import compact

TURN, SHIFT = exp_so3(np.array([0.7, -0.4, 1.3])), np.array([0.3, -0.2, 0.5])
both_ways = pytest.mark.parametrize("other_patient", [False, True])


def rig_of(rig: Rig, vertices: Array, faces: Integers) -> Rig:
    """A rig whose template is this surface; it is never posed here."""
    return replace(rig, template=vertices, faces=faces, regions={})


def fitted(vertices: Array, faces: Integers, scan: tuple[Array, Integers] | None = None) -> FittedScan:
    """The model on a scan, by default one that is just its surface."""
    return FittedScan(ScanTarget(*(scan or subdivided(vertices, faces))), vertices, {}, "standing")


def moved(points: Array) -> Array:
    return np.asarray(points @ TURN.T + SHIFT)


def shape(points: Array, closed: bool = False, bridged: Array | None = None) -> Polyline:
    return Polyline("cut", closed, "#123456", points, np.zeros(len(points), np.bool_) if bridged is None else bridged)


def circle(radius: float, count: int = 100) -> Array:
    angles = 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)


@both_ways
def test_a_line_on_a_plane_moves_with_the_plane(other_patient: bool, toy_rig: Rig) -> None:
    vertices, faces = plane()
    rig = rig_of(toy_rig, vertices, faces)
    line = np.array([[-0.05, -0.02, 0.0], [0.03, 0.01, 0.0], [0.04, 0.05, 0.0]])
    (found,) = transferred(rig, fitted(vertices, faces), fitted(moved(vertices), faces), [shape(line)], other_patient)
    assert (found.line.name, found.line.closed, found.line.color) == ("cut", False, "#123456")
    assert not found.line.bridged.any()
    for corner in moved(line):  # corners stay corners
        assert np.linalg.norm(found.line.points - corner, axis=1).min() < 1e-6
    back = (found.line.points - SHIFT) @ TURN
    assert np.abs(back[:, 2]).max() < 1e-6
    steps = np.linalg.norm(np.diff(back, axis=0), axis=1)
    assert steps.max() < 0.003 + 1e-6
    assert steps.sum() == pytest.approx(np.linalg.norm(np.diff(line, axis=0), axis=1).sum(), abs=1e-6)
    assert max(found.distance_from.max(), found.distance_to.max()) < 1e-6


def test_corners_stay_corners_and_an_error_band_of_the_first_scan_is_not_handed_on(toy_rig: Rig) -> None:
    """How far off a line may be on the second scan is not how far off it may be on the first."""
    vertices, faces = plane()
    rig = rig_of(toy_rig, vertices, faces)
    points = np.array([[-0.05, -0.02, 0.0], [0.03, 0.01, 0.0], [0.03, 0.02, 0.0], [0.04, 0.05, 0.0]])
    line = replace(shape(points), corners=(1, 2), error=np.full(4, 0.001))
    (found,) = transferred(rig, fitted(vertices, faces), fitted(moved(vertices), faces), [line])
    np.testing.assert_allclose(found.line.points[list(found.line.corners)], moved(points[[1, 2]]), atol=1e-6)
    assert found.line.error is None


@both_ways
def test_a_circle_on_a_sphere_moves_with_the_sphere(other_patient: bool, toy_rig: Rig) -> None:
    vertices, faces = sphere()
    rig = rig_of(toy_rig, vertices, faces)
    a, b = fitted(vertices, faces), fitted(moved(vertices), faces)
    line = a.target.search.query(circle(0.08) + np.array([0.0, 0.0, 0.06])).points
    (found,) = transferred(rig, a, b, [shape(line, closed=True)], other_patient)
    assert len(found.line.points) >= len(line)
    gaps = np.linalg.norm(moved(line)[:, None] - found.line.points, axis=2).min(axis=1)
    assert gaps.max() < 0.02e-3
    assert b.target.search.query(found.line.points).distances.max() < 1e-9


def test_between_corners_that_are_far_apart_the_line_follows_the_skin(toy_rig: Rig) -> None:
    vertices, faces = sphere()
    rig = rig_of(toy_rig, vertices, faces)
    a = fitted(vertices, faces)
    corners = a.target.search.query(0.1 * np.eye(3)).points  # a quarter of a great circle each
    (found,) = transferred(rig, a, a, [shape(corners, closed=True)])
    steps = np.linalg.norm(np.roll(found.line.points, -1, axis=0) - found.line.points, axis=1)
    assert steps.max() < 0.0031
    assert steps.sum() == pytest.approx(3 * 0.1 * np.pi / 2, rel=5e-3)
    off = np.abs(found.line.points).min(axis=1)  # three planes through the centre hold the three arcs
    assert off.max() < 1.5e-3
    for corner in corners:
        assert np.linalg.norm(found.line.points - corner, axis=1).min() < 1e-5


def test_over_a_gap_of_the_first_scan_the_line_goes_straight(toy_rig: Rig) -> None:
    vertices, faces = plane(0.3, 60)
    rig = rig_of(toy_rig, vertices, faces)
    a = fitted(vertices, faces, wall_with_a_hole(vertices, faces, behind=False))
    b = fitted(vertices, faces, (vertices, faces))
    (found,) = transferred(rig, a, b, [shape(np.array([[-0.05, 0.01, 0.0], [0.05, 0.01, 0.0]]))])
    assert np.abs(found.line.points[:, 1:] - [0.01, 0.0]).max() < 1e-6
    assert np.linalg.norm(np.diff(found.line.points, axis=0), axis=1).max() < 0.006
    assert np.isnan(found.distance_from[np.abs(found.line.points[:, 0]) < 0.015]).all()
    assert not found.line.bridged.any()


def test_each_point_says_how_far_both_fits_were_from_their_scans(toy_rig: Rig) -> None:
    vertices, faces = sphere()
    rig = rig_of(toy_rig, vertices, faces)
    scan = subdivided(vertices, faces)
    a, b = fitted(1.02 * vertices, faces, scan), fitted(vertices, faces, scan)  # 2 mm outside of its scan
    points = scan[0][np.linalg.norm(scan[0] - [0.0, 0.0, 0.1], axis=1) < 0.03]
    (found,) = transferred(rig, a, b, [shape(points[:1])])
    assert found.distance_from == pytest.approx([0.002], abs=0.03e-3)
    assert found.distance_to == pytest.approx([0.0], abs=0.03e-3)
    assert np.linalg.norm(found.line.points[0] - points[0]) < 0.3e-3


def wall_with_a_hole(vertices: Array, faces: Integers, behind: bool) -> tuple[Array, Integers]:
    """The plane without its middle, perhaps with another wall 5 mm behind that faces the other way."""
    kept = np.abs(vertices[faces].mean(axis=1)[:, 0]) > 0.02
    holed, left = compact(vertices, faces[kept])
    if not behind:
        return holed, left
    back = vertices - [0.0, 0.0, 0.005]
    return np.concatenate([holed, back]), np.concatenate([left, faces[:, ::-1] + len(holed)])


@pytest.mark.parametrize(("behind", "other_patient"), [(True, False), (False, True)])
def test_a_hole_is_bridged_and_nothing_falls_through_it(behind: bool, other_patient: bool, toy_rig: Rig) -> None:
    vertices, faces = plane(0.3, 60)
    rig = rig_of(toy_rig, vertices, faces)
    a = fitted(vertices, faces, (vertices, faces))
    b = fitted(vertices, faces, wall_with_a_hole(vertices, faces, behind))
    line = np.stack([np.linspace(-0.06, 0.06, 61), np.zeros(61), np.zeros(61)], axis=1)
    (found,) = transferred(rig, a, b, [shape(line)], other_patient)
    across = found.line.points[:, 0]
    assert found.line.bridged[np.abs(across) < 0.019].all()
    assert not found.line.bridged[np.abs(across) > 0.027].any()
    assert np.abs(found.line.points[:, 2]).max() < 0.5e-3
    assert np.isnan(found.distance_to[found.line.bridged]).all()
    assert np.isfinite(found.distance_to[~found.line.bridged]).all()
    assert np.isfinite(found.distance_from).all()


def test_a_round_trip_from_a_scan_to_itself_returns_each_point(torso: Rig) -> None:
    vertices = torso.template
    scan_vertices, scan_faces = subdivided(vertices, torso.faces)
    rng = np.random.default_rng(7)
    noisy = scan_vertices + rng.normal(scale=0.3e-3, size=scan_vertices.shape)
    a = fitted(vertices + np.array([0.0, 0.0, 0.002]), torso.faces, (noisy, scan_faces))  # the fit is 2 mm off
    breasts = np.concatenate([torso.regions["breast_L"], torso.regions["breast_R"]])
    points = a.target.search.query(vertices[breasts]).points
    shapes = [Polyline(str(k), False, "#000000", point[None], np.zeros(1, np.bool_)) for k, point in enumerate(points)]
    found = transferred(torso, a, a, shapes)
    back = np.concatenate([each.line.points for each in found])
    kept = ~np.concatenate([each.line.bridged for each in found])
    assert kept.mean() > 0.99
    assert np.linalg.norm(back - points, axis=1)[kept].max() < 0.5e-3


def test_points_that_were_bridged_may_lie_off_the_scan_and_others_not(toy_rig: Rig) -> None:
    vertices, faces = plane()
    rig, a = rig_of(toy_rig, vertices, faces), fitted(vertices, faces)
    line = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.012], [0.02, 0.0, 0.0]])
    with pytest.raises(BadDrawing, match=r'^Point 2 of "cut" is 12 mm away from the scan; .*\.$'):
        transferred(rig, a, a, [shape(line)])
    (found,) = transferred(rig, a, a, [shape(line, bridged=np.array([False, True, False]))])
    assert np.isnan(found.distance_from).sum() >= 1
    assert np.isfinite(found.distance_from[[0, -1]]).all()


def test_a_fit_that_is_not_on_its_scan_is_refused(torso: Rig) -> None:
    a = fitted(torso.template, torso.faces)
    off = replace(a, vertices=a.vertices + 1.0)
    with pytest.raises(BadDrawing, match="does not lie on its scan"):
        transferred(torso, a, off, [shape(a.target.vertices[:1])])
