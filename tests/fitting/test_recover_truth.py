"""A scan made by posing the rig is fitted back: the model, the Jacobian and the solver agree on one truth."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitIterate, FitTask, fit_iterates
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def for_scans_without_noise(recipe: Recipe) -> Recipe:
    """The default recipe with one more stage that trusts the scan to 0.02 mm."""
    shape = recipe.stages[-1]
    exact = shape.model_copy(
        update={
            "name": "exact",
            "iterations": 60,
            "tighten": 10,
            "max_distance": (0.015, 0.015),
            "data_sigma": (0.004, 0.00002),
            "landmark_sigma": (0.003, 0.0005),
            "kernel": "none",
            "reject_border": False,
        }
    )
    return recipe.model_copy(update={"stages": (*recipe.stages, exact)})


def fitted(rig: Rig, seed: int, recipe: Recipe) -> tuple[list[FitIterate], ScanTarget, Array]:
    target, landmarks, truth = patient(rig, seed)
    task = FitTask(rig, target, start_from_landmarks(rig, landmarks), recipe, landmarks)
    return list(fit_iterates(task)), target, truth


@pytest.mark.parametrize("seed", range(3))
def test_a_scan_made_by_the_rig_is_fitted_back_to_a_hundredth_of_a_millimetre(seed: int, torso: Rig) -> None:
    iterates, target, truth = fitted(torso, seed, for_scans_without_noise(load_recipe("default")))
    assert iterates[-1].status is Status.CONVERGED
    vertices = pose(torso, iterates[-1].parameters)
    assert target.search.query(vertices).distances.mean() < 0.01e-3
    assert (
        np.linalg.norm(vertices - truth, axis=1).mean() < 0.05e-3
    )  # every vertex at its own place, not only on the skin


def test_the_default_preset_is_within_half_a_millimetre_of_a_scan_that_the_rig_can_show(torso: Rig) -> None:
    iterates, target, _ = fitted(torso, 0, load_recipe("default"))
    vertices = pose(torso, iterates[-1].parameters)
    assert target.search.query(vertices).distances.mean() < 0.5e-3


def test_iterates_are_numbered_frozen_and_end_with_a_reason(torso: Rig) -> None:
    iterates, _, _ = fitted(torso, 1, load_recipe("default"))
    assert [iterate.iteration for iterate in iterates] == list(range(len(iterates)))
    assert all(iterate.status is Status.RUNNING for iterate in iterates[:-1])
    assert iterates[-1].status is not Status.RUNNING
    assert iterates[-1].mean_distance < 0.2 * iterates[0].mean_distance
    with pytest.raises(ValueError, match="read-only"):
        iterates[0].parameters.weights[0] = 1.0


@pytest.mark.parametrize("constraint", ["simplex", "box", "free"])
def test_the_weights_keep_their_constraint_in_every_iterate(constraint: str, torso: Rig) -> None:
    recipe = load_recipe("default")
    recipe = recipe.model_copy(update={"shapes": recipe.shapes.model_copy(update={"constraint": constraint})})
    iterates, _, _ = fitted(torso, 2, recipe)
    for iterate in iterates:
        weights = iterate.parameters.weights
        if constraint == "simplex":
            assert weights.min() >= 0.0
            assert weights.sum() <= 1.0 + 1e-9
        if constraint == "box":
            assert (weights >= np.array([shape.min for shape in torso.shapes]) - 1e-12).all()
            assert (weights <= np.array([shape.max for shape in torso.shapes]) + 1e-12).all()
    assert iterates[-1].mean_distance < 0.5 * iterates[0].mean_distance


def test_scales_stay_inside_the_rigs_limits(torso: Rig) -> None:
    iterates, _, _ = fitted(torso, 0, load_recipe("default"))
    scales = iterates[-1].parameters.scales
    assert (scales >= np.array([bone.scale_min for bone in torso.bones]) - 1e-12).all()
    assert (scales <= np.array([bone.scale_max for bone in torso.bones]) + 1e-12).all()


def test_stopping_to_consume_stops_the_fit(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 0)
    steps = fit_iterates(
        FitTask(torso, target, start_from_landmarks(torso, landmarks), load_recipe("default"), landmarks)
    )
    assert next(steps).iteration == 0
    steps.close()
    assert next(steps, None) is None


def test_without_rays_the_trees_alone_give_the_same_fit(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 1)
    surfaces = []
    for use_rays in (True, False):
        scan = ScanTarget(target.vertices, target.faces, use_rays=use_rays)
        task = FitTask(torso, scan, start_from_landmarks(torso, landmarks), load_recipe("default"), landmarks)
        surfaces.append(pose(torso, list(fit_iterates(task))[-1].parameters))
    assert np.linalg.norm(surfaces[0] - surfaces[1], axis=1).mean() < 0.5e-3
