"""Lines laid on hand-made surfaces: where each point must be is known."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.project_drawing import SPACING, on_scan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig

Mesh = tuple[np.ndarray, np.ndarray]


def laid(
    rig: Rig, model: Mesh, line: np.ndarray, scan: Mesh, *, closed: bool = False, corners: tuple[int, ...] = ()
) -> Polyline:
    """(M, 3) m points of the model's surface, laid on the scan."""
    vertices, faces = model
    found = ClosestPointSearch(vertices, faces).query(line)
    assert found.distances.max() < 2e-3
    shape = DrawnShape("line", "", closed, "#000000", SurfacePoints(found.faces, found.barycentric), corners)
    (result,) = on_scan(replace(rig, faces=faces), vertices, ModelDrawing("one", "", (shape,)), ScanTarget(*scan))
    return result


def straight(count: int = 30, length: float = 0.14) -> np.ndarray:
    return np.stack([np.linspace(-length / 2, length / 2, count), np.full(count, 0.011), np.zeros(count)], axis=1)


def sheet(height: float, cells: int = 101, size: float = 0.202) -> Mesh:
    vertices, faces = plane(size, cells)
    return vertices + np.array([0.0, 0.0, height]), faces


def holed(mesh: Mesh, radius: float) -> Mesh:
    vertices, faces = mesh
    return vertices, faces[np.linalg.norm(vertices[faces].mean(axis=1)[:, :2], axis=1) > radius]


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def test_on_a_parallel_plane_it_is_lifted_straight_and_even(toy_rig: Rig) -> None:
    line = laid(toy_rig, plane(), straight(), sheet(0.002))
    assert not line.bridged.any()
    np.testing.assert_allclose(line.points[:, 2], 0.002, atol=1e-9)
    np.testing.assert_allclose(line.points[:, 1], 0.011, atol=1e-7)
    np.testing.assert_allclose(line.points[[0, -1], 0], [-0.07, 0.07], atol=1e-7)
    steps = np.linalg.norm(np.diff(line.points, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), atol=1e-6)
    assert 0.8 * SPACING < steps.mean() <= SPACING


@pytest.mark.parametrize(("closed", "corners"), [(False, (0, 10, 29)), (False, ()), (True, (10, 20)), (True, ())])
def test_its_corners_stay_corners_and_its_ends_are_none(closed: bool, corners: tuple[int, ...], toy_rig: Rig) -> None:
    drawn = straight()
    drawn[:, 1] += 0.05 * np.sin(np.linspace(0.0, np.pi, 30))
    line = laid(toy_rig, plane(), drawn, sheet(0.002), closed=closed, corners=corners)
    inner = [corner for corner in corners if closed or 0 < corner < 29]
    np.testing.assert_allclose(line.points[list(line.corners), :2], drawn[inner, :2], atol=1e-6)


def test_a_circle_on_a_larger_ball_lies_on_it_and_does_not_shrink(toy_rig: Rig) -> None:
    """Around the pole at 30 degrees; the ball of the scan is 3 mm larger."""
    ball, larger = sphere(0.100, 5), sphere(0.103, 5)
    turn = np.linspace(0.0, 2 * np.pi, 61)[:-1]
    circle = 0.1 * np.stack([0.5 * np.cos(turn), 0.5 * np.sin(turn), np.full(60, np.cos(np.pi / 6))], axis=1)
    line = laid(toy_rig, ball, circle, larger, closed=True)
    assert not line.bridged.any()
    assert ClosestPointSearch(*larger).query(line.points).distances.max() < 1e-9
    np.testing.assert_allclose(np.hypot(line.points[:, 0], line.points[:, 1]), 0.0515, atol=2e-4)


def test_noise_is_smoothed_on_the_skin(toy_rig: Rig) -> None:
    vertices, faces = sheet(0.002)
    rough = vertices + np.array([0.0, 0.0, 4e-4]) * np.random.default_rng(3).normal(size=(len(vertices), 1))
    line = laid(toy_rig, plane(), straight(), (rough, faces))
    assert not line.bridged.any()
    assert ClosestPointSearch(rough, faces).query(line.points).distances.max() < 1e-9
    assert np.abs(line.points[:, 1] - 0.011).max() < 6e-4  # the line stays straight seen from the front


def test_a_hole_is_bridged_without_a_step(toy_rig: Rig) -> None:
    """The skin rises from 1 to 5 mm over the model across a hole of 60 mm."""
    vertices, faces = holed(sheet(0.0), 0.03)
    tilted = vertices + np.array([0.0, 0.0, 1.0]) * (0.003 + 0.002 * vertices[:, [0]] / 0.1)
    line = laid(toy_rig, plane(), straight(), (tilted, faces))
    inside = np.hypot(line.points[:, 0], line.points[:, 1]) < 0.027
    outside = np.hypot(line.points[:, 0], line.points[:, 1]) > 0.034
    assert line.bridged[inside].all()
    assert not line.bridged[outside].any()
    assert ClosestPointSearch(tilted, faces).query(line.points[~line.bridged]).distances.max() < 1e-9
    wanted = 0.003 + 0.02 * line.points[:, 0]
    np.testing.assert_allclose(line.points[:, 2], wanted, atol=1e-4)
    steps = np.diff(line.points[:, 2])
    assert np.abs(steps).max() < 3e-4


def test_beyond_the_end_of_the_scan_it_fades_to_the_model(toy_rig: Rig) -> None:
    vertices, faces = sheet(0.004)
    cut = vertices, faces[(vertices[faces][:, :, 0] < 0.0).all(axis=1)]
    line = laid(toy_rig, plane(), straight(), cut)
    assert line.bridged[line.points[:, 0] > 0.003].all()
    assert not line.bridged[line.points[:, 0] < -0.005].any()
    beyond = line.points[line.points[:, 0] > 0.0, 2]
    assert (np.diff(beyond) <= 1e-12).all()
    assert beyond[0] > 0.0037
    assert beyond[-1] < 1e-6


@pytest.mark.parametrize(("far", "radius"), [(0.012, 0.008), (0.018, 0.03), (0.03, 0.05), (-0.02, 0.05)])
def test_through_a_hole_it_does_not_jump_to_another_sheet(toy_rig: Rig, far: float, radius: float) -> None:
    scan = joined(holed(sheet(0.002), radius), sheet(far))
    line = laid(toy_rig, plane(), straight(80), scan)
    np.testing.assert_allclose(line.points[:, 2], 0.002, atol=1e-6)
    reach = np.hypot(line.points[:, 0], line.points[:, 1])
    if radius > 0.015:
        assert line.bridged[reach < radius - 0.003].all()
    assert not line.bridged[reach > radius + 0.005].any()


def test_without_any_skin_it_is_the_models_line_and_says_so(toy_rig: Rig) -> None:
    line = laid(toy_rig, plane(), straight(), sheet(0.2))
    assert line.bridged.all()
    np.testing.assert_allclose(line.points[:, 2], 0.0, atol=1e-12)


@pytest.mark.parametrize("closed", [True, False])
def test_marked_corners_stay(toy_rig: Rig, closed: bool) -> None:
    """A square of 60 mm whose corners are not at even steps."""
    corners = 0.03 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    ways = [np.linspace(corners[k], corners[(k + 1) % 4], 5 + k)[:-1] for k in range(4)]
    at = tuple(np.cumsum([0, *(len(way) for way in ways[:-1])]).tolist())
    line = laid(toy_rig, plane(), np.concatenate(ways), sheet(0.002), closed=closed, corners=at)
    for corner in corners:
        assert np.linalg.norm(line.points - corner - [0.0, 0.0, 0.002], axis=1).min() < 1e-9
    assert (np.abs(np.abs(line.points[:, :2]).max(axis=1) - 0.03) < 1e-9).all()  # nothing is cut
