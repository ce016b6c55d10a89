"""A scan made by posing the rig is fitted back: the model, the Jacobian and the solver agree on one truth."""

import numpy as np
import pytest
from helpers.other_mesh import retriangulated
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitIterate, FitTask, fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.geometry.normals import vertex_normals
from breastrig.least_squares.newton import Status
from breastrig.rig.joints import Joints
from breastrig.rig.model import LEAST_GAP, Rig
from breastrig.rig.skinning import pose

pytestmark = pytest.mark.long


def for_scans_without_noise(recipe: Recipe) -> Recipe:
    """The default recipe with one more stage that trusts the scan to 0.02 mm.

    Vertices are what is observed: the skin of these patients is as flat between them as the model's triangles.
    """
    shape = recipe.stages[-1]
    exact = shape.model_copy(
        update={
            "name": "exact",
            "iterations": 60,
            "tighten": 10,
            "temperature": (1.0, 0.005),
            "reject_border": False,
        }
    )
    observed = recipe.observed.model_copy(update={"skin_outlier": None})
    return recipe.model_copy(update={"stages": (*recipe.stages, exact), "observed": observed, "observations": None})


def fitted(rig: Rig, seed: int, recipe: Recipe) -> tuple[list[FitIterate], ScanTarget, Array]:
    target, landmarks, truth = patient(rig, seed)
    task = FitTask(rig, target, start_from_landmarks(rig, landmarks), recipe, {}).with_picks(landmarks)
    return list(fit_iterates(task)), target, truth


@pytest.mark.slow
def test_a_scan_made_by_the_rig_is_fitted_back_to_a_hundredth_of_a_millimetre(torso: Rig) -> None:
    iterates, target, truth = fitted(torso, 1, for_scans_without_noise(load_recipe("default")))
    assert iterates[-1].status is Status.CONVERGED
    vertices = pose(torso, iterates[-1].parameters)
    assert target.search.query(vertices).distances.mean() < 0.01e-3
    assert (
        np.linalg.norm(vertices - truth, axis=1).mean() < 0.05e-3
    )  # every vertex at its own place, not only on the skin


class Rescanned:
    """A patient of the rig under another triangulation (6 mm), noisy along its normals, with inexact picks."""

    def __init__(self, rig: Rig, seed: int, noise: float, clicks: float) -> None:
        self._rig, rng = rig, np.random.default_rng(seed)
        _, exact, self._truth = patient(rig, seed)
        vertices, faces = retriangulated(self._truth, rig.faces, 0.006)
        off = noise * rng.normal(size=len(vertices))
        self.target = ScanTarget(vertices + off[:, None] * vertex_normals(vertices, faces), faces)
        self._exact = np.array(list(exact.values()))
        self.landmarks = {name: at + clicks / np.sqrt(3.0) * rng.normal(size=3) for name, at in exact.items()}

    def errors_mm(self, recipe: Recipe) -> tuple[float, float, float]:
        """Means: fitted vertices to the true surface, to their own true places, landmarks to theirs."""
        rig, start = self._rig, start_from_landmarks(self._rig, self.landmarks)
        last = list(fit_iterates(FitTask(rig, self.target, start, recipe, {}).with_picks(self.landmarks)))[-1]
        assert last.status is Status.CONVERGED
        vertices = pose(rig, last.parameters)
        off = ScanTarget(self._truth, rig.faces).search.query(vertices).distances
        slid = np.linalg.norm(vertices - self._truth, axis=1)
        gaps = np.linalg.norm(rig.landmark_points().positions(vertices, rig.faces) - self._exact, axis=1)
        return 1e3 * float(off.mean()), 1e3 * float(slid.mean()), 1e3 * float(gaps.mean())


@pytest.mark.slow
def test_noise_and_clicks_beside_the_place_are_averaged_out(torso: Rig) -> None:
    """Every error stays under that of what it was made from: 1 and 3 mm."""
    errors = Rescanned(torso, 0, 0.001, 0.003).errors_mm(load_recipe("default"))
    assert (np.array(errors) < (0.42, 2.6, 2.0)).all(), errors


def test_iterates_are_numbered_frozen_and_end_with_a_reason_on_the_scan_within_the_rigs_limits(torso: Rig) -> None:
    iterates, target, _ = fitted(torso, 0, load_recipe("default"))
    vertices, scales = pose(torso, iterates[-1].parameters), iterates[-1].parameters.scales
    assert target.search.query(vertices).distances.mean() < 0.5e-3
    assert (scales >= np.array([bone.scale_min for bone in torso.bones]) - 1e-12).all()
    assert (scales <= np.array([bone.scale_max for bone in torso.bones]) + 1e-12).all()
    assert [iterate.iteration for iterate in iterates] == list(range(len(iterates)))
    assert all(iterate.status is Status.RUNNING for iterate in iterates[:-1])
    assert iterates[-1].status is not Status.RUNNING
    assert iterates[-1].mean_distance < 0.2 * iterates[0].mean_distance
    with pytest.raises(ValueError, match="read-only"):
        iterates[0].parameters.weights[0] = 1.0


@pytest.mark.slow
def test_the_weights_keep_their_ranges_in_every_iterate(torso: Rig) -> None:
    iterates, _, _ = fitted(torso, 2, load_recipe("default"))
    for iterate in iterates:
        weights = iterate.parameters.weights
        assert (weights >= np.array([shape.min for shape in torso.shapes]) - 1e-12).all()
        assert (weights <= np.array([shape.max for shape in torso.shapes]) + 1e-12).all()
    assert iterates[-1].mean_distance < 0.5 * iterates[0].mean_distance


def test_stopping_to_consume_stops_the_fit(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 0)
    steps = fit_iterates(
        FitTask(
            torso,
            target,
            start_from_landmarks(torso, landmarks),
            load_recipe("default"),
            {},
        ).with_picks(landmarks)
    )
    assert next(steps).iteration == 0
    steps.close()
    assert next(steps, None) is None


@pytest.mark.slow
def test_joints_of_the_least_gap_hold_where_others_give_millimetres(torso: Rig) -> None:
    recipe = load_recipe("default")
    hard = recipe.model_copy(update={"joints": recipe.joints.model_copy(update={"translation_factor": 1e-9})})
    joints = Joints(torso, torso.joints)
    iterates, target, _ = fitted(torso, 1, hard)
    last = iterates[-1].parameters
    assert iterates[-1].status is Status.CONVERGED
    assert target.search.query(pose(torso, last)).distances.mean() < 0.6e-3
    assert np.linalg.norm(joints.motion(last).gap, axis=1).max() < LEAST_GAP  # others give by more than 2 mm
