"""What is said of a lesion on a scan, where the body is a ball or the model itself."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.inside.lesions import LesionsOnScan
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanLesion, PlanLine, PlanTumour
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig

KNOWN = "error_skin = 0.005\nerror_share = 0.0\ninside_depth_share = 0.5\nsurface_error = 0.003\n"
HALF = 1.6449 / 2.5003  # half of the interval along a line, of the ball's radius: both hold nine of ten


@pytest.fixture(scope="module")
def ball(toy_rig: Rig) -> Rig:
    vertices, faces = sphere(subdivisions=4)
    return replace(toy_rig, template=vertices, faces=faces, regions={}, known={"skin_map.toml": KNOWN})


def scanned(rig: Rig, keep: np.ndarray | None = None, stance: str = "standing") -> FittedScan:
    faces = rig.faces if keep is None else rig.faces[keep[rig.faces].all(axis=1)]
    return FittedScan(ScanTarget(rig.template, faces), rig.template, {}, stance, np.full(len(rig.template), 0.004))


def places(rig: Rig) -> dict[str, np.ndarray]:
    return dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))


def lesion(center: list[float]) -> PlanLesion:
    return PlanLesion(id="m", name="MRI 1", center=center, radius_mm=6.0)


def test_distances_to_skin_and_lines_with_what_both_ends_leave_open(ball: Rig) -> None:
    points = [[0.0, 80.0, 60.0], [0.0, 99.0, 14.0], [0.0, 100.0, 0.0]]
    lines = [PlanLine(id=k, name=k, points=part) for k, part in (("far", points[:2]), ("near", points[1:]))]
    a, b = scanned(ball), scanned(ball, stance="supine")
    for here, others, own in (
        (a, [], True),
        (b, [PlannedScan("standing", a, [lesion([0.0, 70.0, 0.0]), *lines])], False),
    ):
        items = [lesion([0.0, 70.0, 0.0]), *lines] if own else []
        (found,) = plan_on_scan(ball, PlannedScan("here", here, items), others).lesions
        skin, _, near, far = found.distances
        assert [(each.kind, each.to) for each in (skin, near, far)] == [
            ("skin", "skin"),
            ("line", "near"),
            ("line", "far"),
        ]
        assert far.length > near.length
        assert (skin.length, found.depth, near.length) == pytest.approx((0.03, 0.03, 0.03), abs=3e-4)
        np.testing.assert_allclose(near.point, [0.0, 0.1, 0.0], atol=3e-3)  # between two points of the line
        along = 0.0 if own else HALF * 0.005 * np.sqrt(3.0 * 0.5**2 / (2.0 + 0.5**2))
        assert skin.margin == pytest.approx(np.hypot(0.003, along), rel=0.01)
        assert near.margin == pytest.approx(0.0 if own else np.hypot(HALF * 0.005, along), rel=0.01)
        assert found.covariance is not None
        assert np.trace(found.covariance) == pytest.approx(0.0 if own else 3.0 * (0.005 / 2.5003) ** 2, rel=1e-3)


def test_skin_that_the_scan_does_not_show_is_said_to_be_a_guess_and_its_band_is_the_fits(ball: Rig) -> None:
    scan = scanned(ball, keep=ball.template[:, 1] < 0.05)
    up, down = LesionsOnScan(ball, scan).own([lesion([0.0, 70.0, 0.0]), lesion([0.0, -70.0, 0.0])])
    assert (up.is_seen, down.is_seen) == (False, True)
    assert up.distances[0].margin == pytest.approx(HALF * 0.004, rel=1e-3)
    assert down.distances[0].margin == pytest.approx(0.003)


def test_nine_of_ten_true_places_and_distances_are_held(ball: Rig) -> None:
    """True centres drawn as the ellipsoid has them, and skin and chest wall off as is said of them."""
    walled = replace(ball, known={"skin_map.toml": KNOWN + "[wall_error]\nstanding = 0.002\nsupine = 0.004\n"})
    a, b = scanned(walled), scanned(walled, stance="supine")
    given = PlannedScan("standing", a, [lesion([0.0, 70.0, 0.0])])
    (found,) = LesionsOnScan(walled, b, 0.5 * walled.template).carried(given.scan, given.items)
    assert found.error == pytest.approx(0.005)
    assert found.covariance is not None
    rng = np.random.default_rng(1)
    off = rng.multivariate_normal(np.zeros(3), found.covariance, 50_000)
    assert (np.linalg.norm(off, axis=1) <= found.error).mean() == pytest.approx(0.9, abs=0.02)
    distances = {each.kind: each for each in found.distances}
    for kind, known in (("skin", 0.003), ("chest_wall", 0.004)):
        each = distances[kind]
        along = (each.point - found.center) / each.length
        changed = off @ along + known / 1.6449 * rng.normal(size=len(off))
        assert (np.abs(changed) <= each.margin).mean() == pytest.approx(0.9, abs=0.01), kind
    (standing,) = LesionsOnScan(walled, a, 0.5 * walled.template).own(given.items)
    assert {each.kind: each.margin for each in standing.distances}["chest_wall"] == pytest.approx(0.002)
    outline = LesionsOnScan(walled, b).outline(found)
    assert outline.error == pytest.approx(np.full(len(outline.points), found.error))


def test_slices_cut_the_skin_around_the_lesion(ball: Rig) -> None:
    (found,) = LesionsOnScan(ball, scanned(ball)).own([lesion([10.0, 60.0, -20.0])])
    assert [cut.plane for cut in found.slices] == ["axial", "sagittal", "coronal"]
    for cut in found.slices:
        points = found.center + np.concatenate(cut.outlines) @ np.stack([cut.right, cut.up])
        np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.1, rtol=5e-3)
        assert len(points) > 40
        assert np.cross(cut.right, cut.up) @ (points - found.center).T == pytest.approx(0.0, abs=1e-9)


def test_the_nearer_nipple_and_the_bodys_directions() -> None:
    rig = read_rig(default_rig_path())
    scan = FittedScan(ScanTarget(rig.template, rig.faces), rig.template, {}, "standing")
    nipple = rig.landmark_points(("nipple_L",)).positions(rig.template, rig.faces)[0]
    (found,) = LesionsOnScan(rig, scan).own([lesion((1e3 * (nipple - [0.0, 0.0, 0.03])).tolist())])
    _, to = found.distances
    assert (to.kind, to.to, to.margin) == ("nipple", "nipple_L", None)
    assert to.length == pytest.approx(0.03, abs=1e-6)
    axial, sagittal, coronal = found.slices
    for direction, expected in (  # the template's own axes: left, up, front
        (axial.right, [1, 0, 0]), (axial.up, [0, 0, 1]), (sagittal.right, [0, 0, -1]), (sagittal.up, [0, 1, 0]),
        (coronal.right, [1, 0, 0]), (coronal.up, [0, 1, 0]),
    ):  # fmt: skip
        np.testing.assert_allclose(direction, expected, atol=1e-6)


def test_how_far_off_a_lesion_far_from_the_breasts_is_is_not_known() -> None:
    rig = read_rig(default_rig_path())
    scan = replace(scanned(rig), landmarks=places(rig))
    known, unknown = (
        lesion((1e3 * (places(rig)[name] - [0.0, 0.0, 0.02])).tolist()) for name in ("nipple_L", "umbilicus")
    )
    for item, is_known in ((known, True), (unknown, False)):
        (own,) = LesionsOnScan(rig, scan).own([item])
        (carried,) = LesionsOnScan(rig, replace(scan, stance="supine")).carried(scan, [item])
        for found in (own, carried):
            assert (found.error is not None) is is_known
            assert all((each.margin is not None) is is_known for each in found.distances)


def test_a_tumour_by_the_clock_whose_depth_is_known_lies_inside_with_its_circle_over_it() -> None:
    rig = read_rig(default_rig_path())
    scan = replace(scanned(rig), landmarks=places(rig))
    hour = {"kind": "tumour", "side": "L", "clock": 10.0, "distance_mm": 30.0, "radius_mm": 10.0}
    deep, flat = (
        PlanTumour.model_validate(hour | {"id": name, "depth_mm": mm}) for name, mm in (("a", 15.0), ("b", None))
    )
    found = plan_on_scan(rig, PlannedScan("standing", scan, [deep, flat]), [])
    (lesion,) = found.lesions
    assert (lesion.item.id, lesion.item.radius_mm, lesion.item.name) == ("a", 10.0, "Tumour, left")
    assert lesion.depth == pytest.approx(0.015, abs=2e-3)
    assert lesion.error == pytest.approx(0.004)
    assert [each.item.id for each in found.lines] == ["a", "b"]
    (carried,) = plan_on_scan(rig, PlannedScan("supine", scan, []), [PlannedScan("standing", scan, [deep])]).lesions
    np.testing.assert_allclose(carried.center, lesion.center, atol=2e-3)
