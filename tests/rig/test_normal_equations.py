"""What is computed by structure equals what the full Jacobian gives."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from helpers.random_pose import random_parameters, skinned_by

from breastrig.rig.model import Rig
from breastrig.rig.normal_equations import normal_equations, vertex_variances
from breastrig.rig.skinning import in_pose
from breastrig.rig.vertex_groups import vertex_groups


def assert_equal_to_dense(rig: Rig, chosen: np.ndarray, rng: np.random.Generator) -> None:
    """Each entry to 1e-10 of what its row and column could have at most."""
    posed = in_pose(rig, random_parameters(rig, rng))
    directions, residual = rng.normal(size=(len(chosen), 3)), rng.normal(size=len(chosen))
    jacobian = posed.rows(chosen, directions)
    found = normal_equations(posed, chosen, directions, residual)
    lengths = np.linalg.norm(jacobian, axis=0)
    most = np.outer(lengths, lengths)
    np.testing.assert_array_less(np.abs(found.hessian - jacobian.T @ jacobian), 1e-10 * most + 1e-300)
    gradient = np.abs(found.gradient - jacobian.T @ residual)
    np.testing.assert_array_less(gradient, 1e-10 * lengths * np.linalg.norm(residual) + 1e-300)
    assert found.energy == pytest.approx(0.5 * residual @ residual, rel=1e-12)
    np.testing.assert_array_equal(found.hessian, found.hessian.T)


def assert_variances_equal_to_dense(rig: Rig, rng: np.random.Generator) -> None:
    posed = in_pose(rig, random_parameters(rig, rng))
    root = rng.normal(size=(posed.x.dof, posed.x.dof))
    everyone = np.arange(len(rig.template))
    expected = np.zeros(len(everyone))
    for axis in np.eye(3):
        expected += ((posed.rows(everyone, np.tile(axis, (len(everyone), 1))) @ root) ** 2).sum(axis=1)
    np.testing.assert_allclose(vertex_variances(posed, root @ root.T), expected, rtol=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_of_any_vertices_in_any_order_and_several_times_each(seed: int, torso: Rig, toy_rig: Rig) -> None:
    rng = np.random.default_rng(seed)
    for rig in (torso, toy_rig, skinned_by(torso, "corrective")):
        assert_equal_to_dense(rig, rng.integers(0, len(rig.template), 1000), rng)


def test_of_every_vertex_of_one_and_of_none(torso: Rig) -> None:
    rng = np.random.default_rng(0)
    for chosen in (np.arange(len(torso.template)), np.array([7]), np.zeros(0, dtype=np.int64)):
        assert_equal_to_dense(torso, chosen, rng)


def test_of_a_rig_without_shapes_and_of_one_whose_vertices_have_one_bone_each(toy_rig: Rig) -> None:
    rng = np.random.default_rng(1)
    bare = replace(toy_rig, shapes=(), blendshapes=np.zeros((0, *toy_rig.template.shape)))
    single = np.eye(len(toy_rig.bones))[toy_rig.skin_weights.argmax(axis=1)]
    for rig in (bare, replace(toy_rig, skin_weights=single)):
        assert_equal_to_dense(rig, np.arange(len(rig.template)), rng)
        assert_variances_equal_to_dense(rig, rng)


@pytest.mark.parametrize("seed", range(3))
def test_the_variances_of_all_vertices_are_those_of_their_rows(seed: int, torso: Rig, toy_rig: Rig) -> None:
    rng = np.random.default_rng(seed)
    for rig in (torso, toy_rig):
        assert_variances_equal_to_dense(rig, rng)


def test_groups_hold_each_vertex_once_with_all_that_moves_it(torso: Rig) -> None:
    grouped = vertex_groups(torso)
    assert sorted(grouped.places) == list(range(len(torso.template)))
    for number, group in enumerate(grouped.groups):
        own = np.flatnonzero(grouped.of_vertex == number)
        assert set(np.flatnonzero(torso.skin_weights[own].any(axis=0))) == set(group.bones)
        assert set(np.flatnonzero(torso.blendshapes[:, own].any(axis=(1, 2)))) == set(group.shapes)


def test_groups_save_half_of_the_products_of_the_torso(torso: Rig) -> None:
    grouped = vertex_groups(torso)
    counts = np.bincount(grouped.of_vertex)
    columns = 9 * len(torso.bones) + len(torso.shapes) + 1
    products = sum(count * len(group.entries) for count, group in zip(counts, grouped.groups, strict=True))
    assert products < 0.5 * len(torso.template) * columns**2


def test_groups_of_the_last_sixteen_rigs_are_kept(toy_rig: Rig) -> None:
    first, *others = (replace(toy_rig, name=f"rig {number}") for number in range(17))
    seen = weakref.ref(first)
    assert vertex_groups(first) is vertex_groups(first)
    del first
    for rig in others:
        vertex_groups(rig)
    gc.collect()
    assert seen() is None
