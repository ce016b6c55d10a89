"""One patient in two stances: the body is the same to rounding, each stance keeps its pose and soft tissue."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.random_pose import random_parameters
from helpers.subdivide import subdivided
from helpers.toy_rig import toy_rig

from breastrig.core.arrays import Array
from breastrig.core.errors import BadSettings
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.fitting.fit import Bodies, FitTask, fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import best_start, start_from_landmarks
from breastrig.fitting.two_stances import (
    ALIKE,
    ONE_BODY,
    Alike,
    Coupling,
    PairIterate,
    body_shapes,
    fit_pair_iterates,
)
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status, assemble, joined_systems, value
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def in_range(rig: Rig, x: RigParameters) -> RigParameters:
    lower, upper = (np.array([getattr(shape, side) for shape in rig.shapes]) for side in ("min", "max"))
    return replace(x, weights=np.clip(x.weights, lower, upper))


def two_stances(rig: Rig, seed: int) -> tuple[RigParameters, RigParameters]:
    """One random body, posed and sagging in two ways."""
    rng = np.random.default_rng(seed)
    first, other = (
        in_range(rig, random_parameters(rig, rng, turn=0.06, move=0.0, scale=0.03, shape=0.7)) for _ in range(2)
    )
    body = body_shapes(rig)
    return first, replace(other, scales=first.scales, weights=np.where(body, first.weights, other.weights))


def task_of(rig: Rig, x: RigParameters, recipe: Recipe, stance: str = "standing") -> tuple[FitTask, Array]:
    """A finer scan of the posed rig with its landmarks, and where each model vertex truly is."""
    vertices = pose(rig, x)
    fine, triangles = subdivided(vertices, rig.faces)
    centre = fine.mean(axis=0)
    places = rig.landmark_points().positions(vertices, rig.faces) - centre
    landmarks = dict(zip(rig.landmark_names, places, strict=True))
    target = ScanTarget(fine - centre, triangles)
    return FitTask(rig, target, start_from_landmarks(rig, landmarks), recipe, {}, stance).with_picks(
        landmarks
    ), vertices - centre


def for_scans_without_noise(recipe: Recipe) -> Recipe:
    """One more stage that trusts the scan to 0.02 mm."""
    exact = recipe.stages[-1].model_copy(
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


def assert_one_body(iterate: PairIterate, rig: Rig) -> None:
    body = body_shapes(rig)
    first, second = iterate.first.parameters, iterate.second.parameters
    np.testing.assert_allclose(first.scales, second.scales, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(first.weights[body], second.weights[body], rtol=0.0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_two_scans_of_one_body_come_back_vertex_by_vertex(seed: int, torso: Rig) -> None:
    recipe = for_scans_without_noise(load_recipe("default"))
    (first, true_first), (second, true_second) = (task_of(torso, x, recipe) for x in two_stances(torso, seed))
    iterates = list(fit_pair_iterates(first, second, ONE_BODY))
    assert iterates[-1].status is Status.CONVERGED
    assert_one_body(iterates[-1], torso)
    for iterate, truth in ((iterates[-1].first, true_first), (iterates[-1].second, true_second)):
        assert np.linalg.norm(pose(torso, iterate.parameters) - truth, axis=1).mean() < 0.05e-3


@pytest.mark.slow
def test_the_body_is_the_same_in_every_iterate_whatever_the_constraint(torso: Rig) -> None:
    for constraint in ("box", "simplex", "free"):
        recipe = load_recipe("default")
        recipe = recipe.model_copy(update={"shapes": recipe.shapes.model_copy(update={"constraint": constraint})})
        (first, _), (second, _) = (task_of(torso, x, recipe) for x in two_stances(torso, 5))
        iterates = list(fit_pair_iterates(first, replace(second, stance="supine"), ONE_BODY))
        assert [iterate.iteration for iterate in iterates] == list(range(len(iterates)))
        for iterate in iterates:
            assert_one_body(iterate, torso)
            for side in (iterate.first, iterate.second):
                assert constraint != "simplex" or side.parameters.weights.min() >= 0.0
                assert constraint != "simplex" or side.parameters.weights.sum() <= 1.0 + 1e-9
        soft = ~body_shapes(torso)
        last = iterates[-1]
        assert (last.first.parameters.weights[soft] != last.second.parameters.weights[soft]).any()
        assert last.first.mean_distance < 0.3 * iterates[0].first.mean_distance


def test_the_same_scan_twice_is_fitted_as_once(torso: Rig) -> None:
    task, _ = task_of(torso, two_stances(torso, 3)[0], load_recipe("default"))
    alone = list(fit_iterates(task))
    twice = list(fit_pair_iterates(task, task, ONE_BODY))
    assert len(alone) == len(twice)
    for single, both in zip(alone, twice, strict=True):
        expected = pose(torso, single.parameters)
        for side in (both.first, both.second):
            np.testing.assert_allclose(pose(torso, side.parameters), expected, atol=1e-6)


@pytest.mark.parametrize("coupling", [ALIKE, Coupling(soft=0.2)])
def test_the_joint_gradient_equals_finite_differences(coupling: Coupling) -> None:
    rig = toy_rig()
    rng = np.random.default_rng(11)
    alike, point = Alike(rig, coupling), Bodies(tuple(BodyState(rig, random_parameters(rig, rng)) for _ in range(2)))
    terms = [
        [
            ScalePrior(rig, 0.1, 0.1),
            ShapePrior(np.full(len(rig.shapes), 0.5), np.zeros(len(rig.shapes))),
            Symmetry(rig, 0.5, 0.1),
            Landmarks(rig, [LandmarkObservation(n, rng.normal(size=3), 0.09 * np.eye(3)) for n in rig.landmark_names]),
        ]
        for _ in range(2)
    ]
    own = [assemble(of_one, [], state) for of_one, state in zip(terms, point.states, strict=True)]
    system = joined_systems(own, assemble([], [alike], point))
    gradient = system.gradient + system.constraint_jacobian.T @ (system.constraint / system.compliance)

    def energy_at(at: Bodies) -> float:
        apart = [value(of_one, [], state).energy for of_one, state in zip(terms, at.states, strict=True)]
        return sum(apart) + value([], [alike], at).energy

    assert system.energy == pytest.approx(energy_at(point))
    for k, move in enumerate(1e-6 * np.eye(point.dof)):
        slope = (energy_at(point.retract(move)) - energy_at(point.retract(-move))) / 2e-6
        assert gradient[k] == pytest.approx(slope, abs=2e-6 * np.abs(gradient).max()), k


@pytest.mark.slow
def test_without_springs_two_bodies_are_two_single_fits(torso: Rig) -> None:
    recipe = load_recipe("default")
    stop = recipe.stop.model_copy(update={"patience": 100})  # as many iterations in both
    recipe = recipe.model_copy(update={"stop": stop})
    tasks = [task_of(torso, x, recipe)[0] for x in two_stances(torso, 2)]
    last = list(fit_pair_iterates(*tasks, Coupling()))[-1]
    for task, side in zip(tasks, (last.first, last.second), strict=True):
        alone = list(fit_iterates(task))[-1]
        np.testing.assert_allclose(pose(torso, side.parameters), pose(torso, alone.parameters), atol=1e-5)


@pytest.mark.slow
def test_bodies_that_are_alike_are_nearer_to_each_other_than_bodies_apart(torso: Rig) -> None:
    tasks = [task_of(torso, x, load_recipe("default"))[0] for x in two_stances(torso, 2)]
    gaps = []
    for coupling in (Coupling(), ALIKE, ONE_BODY):
        last = list(fit_pair_iterates(*tasks, coupling))[-1]
        gaps.append(np.abs(last.first.parameters.scales - last.second.parameters.scales).mean())
    assert gaps[0] > gaps[1] > gaps[2] < 1e-12


@pytest.mark.slow
def test_a_scan_without_landmarks_starts_by_itself(torso: Rig) -> None:
    (first, _), (second, truth) = (task_of(torso, x, load_recipe("default")) for x in two_stances(torso, 1))
    blind = replace(
        second.with_picks({}), start=best_start(torso, second.target, {}, lambda: np.array([[0.0, 0.0, 1.0]]))
    )
    last = list(fit_pair_iterates(first, blind, ONE_BODY))[-1]
    assert last.status is Status.CONVERGED
    assert last.second.landmark_distance is None
    assert last.first.landmark_distance is not None
    assert last.second.mean_distance < 1e-3
    assert np.linalg.norm(pose(torso, last.second.parameters) - truth, axis=1).mean() < 8e-3


def test_stances_of_different_models_or_presets_are_refused(torso: Rig) -> None:
    task, _ = task_of(torso, two_stances(torso, 3)[0], load_recipe("default"))
    with pytest.raises(BadSettings, match="one model"):
        next(fit_pair_iterates(task, replace(task, rig=toy_rig())))
    with pytest.raises(BadSettings, match="one preset"):
        next(fit_pair_iterates(task, replace(task, recipe=load_recipe("paper"))))


def test_a_scan_that_is_nowhere_near_ends_the_fit_with_a_reason(torso: Rig) -> None:
    task, _ = task_of(torso, two_stances(torso, 3)[0], load_recipe("default"))
    away = replace(task.with_picks({}), target=ScanTarget(task.target.vertices + 9.0, task.target.faces))
    assert [iterate.status for iterate in fit_pair_iterates(task, away)] == [Status.STALLED]
