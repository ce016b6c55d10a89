"""The steps that make the example patient, on shapes of a few hundred vertices."""

import numpy as np
import pytest
from virtual_patient.lying import Tissue, back_on_table, belly_lying, breasts_lying, chest_wall

from breastrig.geometry.normals import face_areas


def mound(height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A round mound of radius 6 cm on a plate that looks to +Z: vertices, triangles, distance from its middle."""
    side = np.linspace(-0.16, 0.16, 41)
    x, y = np.meshgrid(side, side, indexing="ij")
    away = np.hypot(x, y)
    z = height * np.clip(1.0 - (away / 0.06) ** 2, 0.0, None) ** 1.5
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces, away.ravel()


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Under the surface, above z = 0."""
    flat = vertices * [1.0, 1.0, 0.0]
    signed = np.linalg.det(np.stack([flat[faces[:, k]][:, :2] - flat[faces[:, 0]][:, :2] for k in (1, 2)], axis=1))
    return float((0.5 * signed * vertices[faces, 2].mean(axis=1)).sum())


def test_the_chest_wall_is_the_surface_without_its_mound() -> None:
    vertices, faces, away = mound(0.04)
    wall = chest_wall(vertices, faces, away < 0.065)
    assert np.abs(wall[:, 2]).max() < 1e-3
    np.testing.assert_array_equal(wall[away >= 0.065], vertices[away >= 0.065])


def test_lying_down_keeps_the_volume_of_the_breast_and_flattens_it() -> None:
    vertices, faces, away = mound(0.04)
    wall = chest_wall(vertices, faces, away < 0.065)
    lying = breasts_lying(vertices, faces, wall, away < 0.14, Tissue())
    assert volume(lying, faces) == pytest.approx(volume(vertices, faces), rel=0.01)
    assert lying[:, 2].max() < vertices[:, 2].max() - 0.008
    still = away > 0.15
    np.testing.assert_allclose(lying[still], vertices[still], atol=1e-9)
    assert (face_areas(lying, faces) > 0.1 * face_areas(vertices, faces)).all()


def test_lying_down_the_top_of_the_breast_moves_to_the_head() -> None:
    vertices, faces, away = mound(0.04)
    wall = chest_wall(vertices, faces, away < 0.065)
    top = int(vertices[:, 2].argmax())
    moved = breasts_lying(vertices, faces, wall, away < 0.14, Tissue())[top] - vertices[top]
    assert moved[1] > 0.004
    assert abs(moved[0]) < 0.001


def test_the_belly_gains_in_width_what_it_loses_in_depth() -> None:
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    slice_ = np.stack([0.15 * np.cos(angle), np.full(400, 0.15), 0.1 * np.sin(angle)], axis=1)
    lying = belly_lying(slice_, np.ones(400), navel=np.array([0.0, 0.155, 0.0]), back=-0.05, tissue=Tissue())

    def area(line: np.ndarray) -> float:
        x, z = line[:, 0], line[:, 2]
        return float(abs((x * np.roll(z, -1) - np.roll(x, -1) * z).sum()) / 2)

    assert area(lying) == pytest.approx(area(slice_), rel=1e-9)
    assert lying[:, 2].max() < slice_[:, 2].max() - 0.008


def test_the_table_presses_the_back_flat_and_leaves_the_front() -> None:
    depth = np.linspace(-0.1, 0.2, 301)
    vertices = np.stack([np.zeros(301), np.zeros(301), depth], axis=1)
    pressed, table = back_on_table(vertices, Tissue())
    assert table == pytest.approx(-0.1 + Tissue().pressed)
    assert pressed[:, 2].min() > table
    assert (np.diff(pressed[:, 2]) > 0).all()
    assert pressed[-1, 2] == pytest.approx(0.2, abs=1e-3)
