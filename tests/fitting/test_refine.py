"""The free-form layer: onto the skin there is, along the normals only, and nowhere else."""

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.refine import BENDING, _Systems, refined, stiffness_and_area
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


def larger_front(height: float) -> ScanTarget:
    """The front half of a ball that is larger than one of 0.1 m by `height`."""
    fine, triangles = sphere(0.1 + height, 5)
    return ScanTarget(*compact(fine, triangles[(fine[triangles][:, :, 2] > 0.0).all(axis=1)]))


def beyond_the_edge(vertices: np.ndarray) -> np.ndarray:
    """(V,) m along the skin of a ball of 0.1 m from the border of its front."""
    return -0.1 * np.arcsin(np.clip(vertices[:, 2] / 0.1, -1.0, 1.0))


@pytest.mark.parametrize("height", [0.004, -0.004])
def test_where_the_scan_ends_the_layer_fades_without_a_step(height: float) -> None:
    vertices, faces = sphere(0.1, 4)
    layer = refined(larger_front(height), vertices, faces).displacement / height
    beyond = beyond_the_edge(vertices)
    assert np.abs(layer[beyond < -0.02] - 1.0).max() < 0.08
    assert np.abs(layer[beyond > 0.09]).max() < 0.05
    corners = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    steps = np.abs(np.diff(layer[corners], axis=1))[:, 0]
    lengths = np.linalg.norm(np.diff(vertices[corners], axis=1)[:, 0], axis=1)
    assert (steps / lengths).max() < 1.0 / 0.04  # no steeper than from all to nothing within 4 cm


def test_the_layer_never_overshoots_where_the_scan_shows_nothing() -> None:
    """A hill that ends at the border with a slope is not carried on, and leaves no ditch behind."""
    vertices, faces = sphere(0.1, 4)
    fine, triangles = sphere(0.1, 5)
    moved = fine * (1.0 + 0.006 * np.clip(1.0 - fine[:, 2:] / 0.05, 0.0, None) / 0.1)
    front = triangles[(fine[triangles][:, :, 2] > 0.0).all(axis=1)]
    layer = refined(ScanTarget(*compact(moved, front)), vertices, faces).displacement
    unseen = beyond_the_edge(vertices) > 0.0
    assert layer[~unseen].max() > 0.0045
    assert layer[unseen].max() < 0.006
    assert layer[unseen].min() > -0.1e-3


def test_one_vertex_that_alone_meets_a_scrap_of_scan_raises_no_spike() -> None:
    vertices, faces = sphere(0.1, 4)
    directions = vertices / 0.1
    scrap = np.linalg.norm(directions - directions[np.argmin(vertices[:, 2])], axis=1) < 0.12  # a vertex and its ring
    fine, triangles = sphere(0.1, 6)
    front = (fine[triangles][:, :, 2] > 0.0).all(axis=1)
    near = np.linalg.norm(fine[triangles].mean(axis=1) / 0.1 - directions[np.argmin(vertices[:, 2])], axis=1) < 0.04
    place = fine.copy()
    place[np.unique(triangles[near])] *= 1.1  # 10 mm off the skin
    layer = refined(ScanTarget(*compact(place, triangles[front | near])), vertices, faces).displacement
    assert scrap.sum() < 10
    assert layer[scrap].max() < 0.004


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


def test_the_systems_are_those_of_their_formula() -> None:
    vertices, faces = sphere(0.1, 3)
    rng, count = np.random.default_rng(4), len(vertices)
    stiffness, area = stiffness_and_area(vertices, faces)
    weight, flat = rng.uniform(0.0, 1e6, count), rng.uniform(0.0, 1e4, count)
    k = stiffness.toarray()
    edges = 0.5 * (flat[:, None] + flat) * (k - np.diag(np.diag(k)))
    wanted = k @ np.diag(1.0 / (area * BENDING**2)) @ k + edges - np.diag(edges.sum(axis=1)) + np.diag(weight)
    systems = _Systems(stiffness, area)
    for _ in range(2):  # the second is not disturbed by the first
        found = systems.system(weight, flat).toarray()
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_oblique_skin_is_reached_along_the_models_normals() -> None:
    """The scan is a plane that is tilted by 34 degrees against a flat model, so the way along the model's normal is
    longer than that along the scan's."""
    tilt, steps = 0.6, np.linspace(-0.018, 0.018, 25)
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    corner = (np.arange(24)[:, None] * 25 + np.arange(24)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + 26], 1), np.stack([corner, corner + 26, corner + 25], 1)]
    )
    model = np.stack([x, y, np.zeros_like(x)], axis=1)
    true = np.tan(tilt) * x
    wide = np.stack([3.0 * x, 3.0 * y, 3.0 * true], axis=1)
    heights = refined(ScanTarget(wide, faces), model, faces).displacement
    inside = np.maximum(abs(x), abs(y)) < 0.010
    np.testing.assert_allclose(heights[inside], true[inside], atol=0.02e-3)
