"""The free-form layer: onto the skin there is, along the normals only, and nowhere else."""

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.refine import FADE, refined, stiffness_and_area
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.scan.clean import compact


def bumpy(vertices: np.ndarray, height: float) -> np.ndarray:
    """A ball of 0.1 m with a smooth hill at its front."""
    directions = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices + height * np.exp(-(((1.0 - directions[:, 2]) / 0.1) ** 2))[:, None] * directions


@pytest.mark.parametrize("height", [0.006, -0.006])
def test_a_smooth_hill_that_the_model_lacks_is_reached(height: float) -> None:
    vertices, faces = sphere(0.1, 4)
    fine, triangles = sphere(0.1, 5)
    target = ScanTarget(bumpy(fine, height), triangles)
    before = target.search.query(vertices).distances
    after = target.search.query(refined(target, vertices, faces).vertices).distances
    assert before.max() > 0.005
    assert after.mean() < 0.1e-3
    assert after.max() < 0.5e-3


def test_nothing_moves_along_the_skin() -> None:
    vertices, faces = sphere(0.1, 4)
    fine, triangles = sphere(0.1, 5)
    moved = refined(ScanTarget(bumpy(fine, 0.006), triangles), vertices, faces).vertices - vertices
    assert np.abs(np.cross(moved, vertex_normals(vertices, faces))).max() < 1e-12


def test_what_the_scan_does_not_show_stays() -> None:
    vertices, faces = sphere(0.1, 4)
    fine, triangles = sphere(0.104, 5)
    front = triangles[(fine[triangles][:, :, 2] > 0.0).all(axis=1)]
    result = refined(ScanTarget(*compact(fine, front)), vertices, faces)
    assert np.abs(result.displacement[vertices[:, 2] > 0.02] - 0.004).max() < 0.3e-3
    assert np.abs(result.displacement[vertices[:, 2] < -10 * FADE]).max() < 0.2e-3


def test_noise_turns_no_triangle_over(rng: np.random.Generator) -> None:
    vertices, faces = sphere(0.1, 4)
    fine, triangles = sphere(0.1, 5)
    target = ScanTarget(fine + rng.normal(scale=0.003, size=fine.shape), triangles)
    result = refined(target, vertices, faces)
    agree = np.einsum("fi,fi->f", face_normals(vertices, faces), face_normals(result.vertices, faces))
    assert agree.min() > 0.0


def test_the_cotangent_stiffness_is_that_of_the_sphere() -> None:
    """xᵀ K x / xᵀ M x of a coordinate function tends to 2 / r², an eigenvalue of the sphere's Laplacian."""
    vertices, faces = sphere(0.1, 4)
    stiffness, area = stiffness_and_area(vertices, faces)
    x = vertices[:, 0]
    assert abs(x @ (stiffness @ x) / (x @ (area * x)) / 200.0 - 1.0) < 0.01
    assert abs(area.sum() / (4.0 * np.pi * 0.01) - 1.0) < 0.01
