"""The inside of fitted bodies: sound tetrahedra, the skin kept, and a wall that breasts do not move."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.random_pose import random_parameters

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput, BadModel
from breastrig.geometry.caps import closed
from breastrig.geometry.rotations import exp_so3
from breastrig.report.files.exported import enclosed_volume
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.volume import volume_of
from breastrig.volume.known_volume import known_volume
from breastrig.volume.tetrahedra import chest_wall, volume_mesh
from breastrig.volume.untangle import _Shapes
from breastrig.volume.volume_mesh import REGIONS, VolumeMesh, outer_triangles

Fitted = tuple[VolumeMesh, Array]


@pytest.fixture(scope="module")
def fitted(rig: Rig, fits: Path) -> Fitted:
    """The mesh of a fit, and the (V, 3) m skin that it was made from."""
    fit = fit_folder_of(fits / "supine", rig)
    return volume_of(fit), fit.vertices


def test_tetrahedra_of_a_fit_are_sound_and_fill_its_closed_skin(fitted: Fitted, rig: Rig) -> None:
    mesh, skin = fitted
    assert mesh.scaled_jacobian.min() >= 0.1
    assert mesh.volumes.min() > 0.0
    capped = closed(skin, rig.faces)
    assert mesh.volumes.sum() == pytest.approx(enclosed_volume(capped.vertices, capped.faces), rel=0.01)
    moved = np.linalg.norm(mesh.points[: len(skin)] - skin, axis=1)
    assert moved.max() == mesh.moved < 0.003
    assert np.median(moved) == 0.0


def test_the_surface_is_the_rigs_own(fitted: Fitted, rig: Rig) -> None:
    mesh, skin = fitted
    outer = {tuple(sorted(row)) for row in outer_triangles(mesh.tetrahedra).tolist()}
    assert {tuple(sorted(row)) for row in mesh.surface.tolist()} < outer
    np.testing.assert_array_equal(mesh.model_vertex[mesh.surface], rig.faces)
    assert (mesh.model_vertex[len(skin) :] == -1).all()


def test_regions_and_sets_say_what_holds_the_breasts(fitted: Fitted, rig: Rig) -> None:
    mesh, skin = fitted
    wall = np.unique(mesh.wall)
    soft, core = (np.unique(mesh.tetrahedra[part]) for part in (mesh.soft, ~mesh.soft))
    np.testing.assert_array_equal(np.setdiff1d(np.intersect1d(soft, core), wall), [])  # they meet at the wall only
    for side in "LR":
        nipple = rig.faces[rig.landmark_points((f"nipple_{side}",)).faces[0]]
        around = np.isin(mesh.tetrahedra, nipple).any(axis=1)
        assert {REGIONS[region] for region in mesh.region[around]} == {f"breast_{side}"}
    assert set(np.unique(mesh.region)) == set(range(len(REGIONS)))
    np.testing.assert_array_equal(np.intersect1d(mesh.fixed, mesh.sliding), [])
    assert np.isin(mesh.sliding, wall).all()
    assert np.isin(core, np.union1d(mesh.fixed, mesh.sliding)).all()
    assert {"cuts", "dense_sternum", "dense_inframammary_L", "dense_lateral_R", "loose_pectoral_L"} <= set(mesh.sets)
    assert (mesh.depth[: len(skin)] == 0.0).all()
    assert ((mesh.depth >= 0.0) & (mesh.depth <= 1.0)).all()
    assert (mesh.depth[mesh.fixed[np.isin(mesh.fixed, wall)]] == 1.0).all()


def test_the_wall_lies_under_the_skin_and_no_breast_moves_it(rig: Rig, rng: np.random.Generator) -> None:
    rest, count = rest_parameters(rig), len(rig.template)
    wall = chest_wall(rig, rest, rig.template)
    np.testing.assert_allclose(wall, known_volume(rig).points[count : 2 * count], atol=1e-9)
    assert (rig.template - wall)[:, 2][rig.regions["areola_L"]].min() > 0.03  # in front of it

    hanging = rig.template.copy()
    for side in "LR":
        hanging[rig.regions[f"breast_{side}"]] += rng.uniform(0.0, 0.05, 3)
    np.testing.assert_allclose(chest_wall(rig, rest, hanging), wall, atol=1e-12)

    turn, shift = exp_so3(rng.normal(size=3)), rng.normal(size=3)
    np.testing.assert_allclose(
        chest_wall(rig, rest.moved(turn, shift), rig.template @ turn.T + shift), wall @ turn.T + shift, atol=1e-9
    )
    thickness = np.linalg.norm(wall - known_volume(rig).chest.of(rig.template), axis=1)
    larger = replace(rest, scales=1.2 * rest.scales)
    skin = pose(rig, larger)
    np.testing.assert_allclose(
        np.linalg.norm(chest_wall(rig, larger, skin) - known_volume(rig).chest.of(skin), axis=1), thickness, atol=1e-9
    )


def test_the_chest_under_breasts_is_that_of_women_without_them(rig: Rig) -> None:
    chest = known_volume(rig).chest
    np.testing.assert_allclose(chest.weights.sum(axis=1), 1.0, atol=0.02)
    other = rig.mirror_vertices
    mirrored = chest.of(rig.template[other] * [-1.0, 1.0, 1.0])
    np.testing.assert_allclose(mirrored[other] * [-1.0, 1.0, 1.0], chest.of(rig.template), atol=1e-3)
    bare = chest.of(rig.template)
    np.testing.assert_allclose(chest.of(bare), bare, atol=0.004)  # nothing is taken away twice


def test_any_body_of_the_rig_is_sound(rig: Rig, rng: np.random.Generator) -> None:
    x = random_parameters(rig, rng, turn=0.05, move=0.002, scale=0.1, shape=0.5)
    mesh = volume_mesh(rig, x, pose(rig, x))
    assert mesh.scaled_jacobian.min() >= 0.1


def test_derivative_of_the_energy_of_shapes(rng: np.random.Generator) -> None:
    points, tetrahedra = rng.normal(size=(8, 3)), np.array([[0, 1, 2, 3], [4, 1, 2, 3], [5, 6, 7, 0]])
    springs, normals = np.array([1.0, 2.0, 0.0, 0.0, 0.0]), rng.normal(size=(5, 3))
    shapes = _Shapes(points, tetrahedra, np.array([0.5, 1.0, 0.8]), np.arange(5), springs, normals)
    at, step = (shapes.start + 0.1 * rng.normal(size=(5, 3))).ravel(), rng.normal(size=15)
    measured = (shapes.energy(at + 1e-6 * step)[0] - shapes.energy(at - 1e-6 * step)[0]) / 2e-6
    assert shapes.energy(at)[1] @ step == pytest.approx(measured, rel=1e-6)


def test_a_rig_without_an_inside_says_so(toy_rig: Rig) -> None:
    with pytest.raises(BadInput, match=r"Nothing is known of the inside of the rig toy"):
        volume_mesh(toy_rig, rest_parameters(toy_rig), toy_rig.template)


def test_the_inside_of_another_rig_is_damaged(toy_rig: Rig, rig: Rig) -> None:
    other = replace(toy_rig, known={"volume.json": rig.known["volume.json"]})
    with pytest.raises(BadModel, match=r"toy.known/volume.json does not belong to this rig"):
        volume_mesh(other, rest_parameters(other), other.template)
