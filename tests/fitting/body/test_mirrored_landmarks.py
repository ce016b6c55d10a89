"""What a pick tells of the landmark on the other side, which nobody picked."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.example_patient import silent

from breastrig.core.arrays import Array
from breastrig.core.stances import split_side
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.landmarks import mirrored_landmarks
from breastrig.fitting.fit import ScanProblem, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import FitIterate, FitTask, ended
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import assemble
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState
from breastrig.scan.clean import compact
from breastrig_studies.virtual.bodies import read_bodies

PICKED = ("suprasternal_notch", "xiphoid", "midclavicle_R", "acromion_L", "nipple_R", "inframammary_fold_L")
PARTNERS = {"midclavicle_L", "acromion_R", "nipple_L", "inframammary_fold_R"}


def standing(number: int) -> tuple[FitTask, dict[str, Array]]:
    """The front of a virtual woman with one pick of each pair, and (3,) m, her landmarks' true places."""
    rig, cohort = read_rig(default_rig_path()), read_bodies()
    body = next(body for body in cohort.patients[number].bodies if body.stance == "standing")
    seen = cohort.faces[(cohort.scanned & (body.vertices[:, 2] > -0.02))[cohort.faces].all(axis=1)]
    vertices, faces = trimesh.remesh.subdivide(*compact(body.vertices, seen))  # as near each other as a scan's
    picks = {name: body.landmarks[name] for name in PICKED}
    target = ScanTarget(vertices, np.asarray(faces))
    return FitTask(rig, target, start_from_landmarks(rig, picks), load_recipe("default"), {}).with_picks(
        picks
    ), body.landmarks


@pytest.fixture(scope="module")
def woman() -> tuple[FitTask, dict[str, Array]]:
    return standing(6)


@pytest.fixture(scope="module")
def task(woman: tuple[FitTask, dict[str, Array]]) -> FitTask:
    return woman[0]


@pytest.fixture(scope="module")
def true(woman: tuple[FitTask, dict[str, Array]]) -> dict[str, Array]:
    return woman[1]


def end(task: FitTask) -> FitIterate:
    *_, last = checked_iterates(task)
    return last


def places(task: FitTask, last: FitIterate) -> dict[str, Array]:
    """(3,) m, of the fitted model's landmarks."""
    points = task.rig.landmark_points()
    found = points.positions(pose(task.rig, last.parameters), task.rig.faces)
    return dict(zip(task.rig.landmark_names, found, strict=True))


def errors(task: FitTask, true: dict[str, Array]) -> dict[str, float]:
    """m, by name."""
    return {name: float(np.linalg.norm(place - true[name])) for name, place in places(task, end(task)).items()}


def on_axis(seen: LandmarkObservation) -> float:
    """m, of an error that is the same on each."""
    return seen.error / np.sqrt(3.0)


def look(task: FitTask) -> tuple[BodyState, dict[str, LandmarkObservation]]:
    """Where the last stage begins, and what the picks then tell of their partners."""
    first = task.recipe.model_copy(update={"stages": task.recipe.stages[:-1]})
    *_, before = fit_iterates(replace(task, recipe=first))
    state, stage, problem = BodyState(task.rig, before.parameters), task.recipe.stages[-1], ScanProblem(task)
    terms = problem.terms(stage, 1.0, state, problem.matches(stage, 1.0, state))
    assert terms.picks is not None
    others = [each for each in terms.residuals if each is not terms.picks and each.name not in ("form", "partners")]
    found = mirrored_landmarks(task, state, terms.picks, lambda: assemble(others, state), problem.scaling)
    return state, {each.name: each for each in found}


def test_a_landmark_that_nobody_picked_follows_its_partner(task: FitTask, true: dict[str, Array]) -> None:
    told, alone = (errors(each, true) for each in (task, replace(task, recipe=silent(task.recipe))))
    assert np.mean([told[name] for name in PARTNERS]) < 0.9 * np.mean([alone[name] for name in PARTNERS])
    assert np.mean([told[name] for name in PICKED]) < np.mean([alone[name] for name in PICKED]) + 1e-4
    assert end(task).mean_distance < end(replace(task, recipe=silent(task.recipe))).mean_distance + 2e-5  # m


def test_the_partner_is_expected_as_far_from_the_model_without_picks_as_the_pick_is(
    task: FitTask, true: dict[str, Array]
) -> None:
    _, found = look(task)
    assert set(found) == PARTNERS
    rig, without = task.rig, places(task, end(replace(task.with_picks({}), recipe=silent(task.recipe))))
    model = np.array([without[name] for name in rig.landmark_names])
    axes = umeyama(rig.landmark_points().positions(rig.template, rig.faces), model).rotation
    for name, each in found.items():
        picked = next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)
        slide = axes @ (np.array([-1.0, 1.0, 1.0]) * (axes.T @ (true[picked] - without[picked])))
        assert np.linalg.norm(each.place - without[name] - slide) < 0.008  # m; of fits that differ by up to 0.02
        assert on_axis(each) == pytest.approx(task.recipe.partners[split_side(name)[0]])


def test_partners_are_expected_where_they_were_on_a_turned_scan(task: FitTask) -> None:
    turn = exp_so3(np.array([0.3, -1.1, 0.7]))
    picks = {name: turn @ place for name, place in task.landmarks.items()}
    target = ScanTarget(task.target.vertices @ turn.T, task.target.faces)
    _, there = look(replace(task.with_picks(picks), target=target, start=start_from_landmarks(task.rig, picks)))
    _, here = look(task)
    assert set(here) == set(there)
    for name, each in here.items():
        np.testing.assert_allclose(turn.T @ there[name].place, each.place, atol=3e-4)


def test_an_unsure_pick_tells_as_little_of_its_partner(task: FitTask) -> None:
    _, found = look(task.with_picks(task.landmarks, {"acromion_L": 0.03}))
    assert on_axis(found["acromion_R"]) == pytest.approx(np.hypot(0.03, task.recipe.partners["acromion"]))


def test_a_partner_on_skin_that_the_scan_does_not_show_is_less_sure(task: FitTask) -> None:
    target, picks = task.target, {name: place for name, place in task.landmarks.items() if not name.endswith("_R")}
    left = (target.vertices[:, 0] > picks["xiphoid"][0] - 0.005)[target.faces].all(axis=1)
    half = ScanTarget(*compact(target.vertices, target.faces[left]))
    _, found = look(replace(task.with_picks(picks), target=half))
    assert set(found) == {"acromion_R", "inframammary_fold_R"}
    for name, each in found.items():
        assert half.vertex_tree.query(each.place)[0] > 0.015  # m
        assert on_axis(each) == pytest.approx(np.hypot(0.01, task.recipe.partners[split_side(name)[0]]))


def test_picked_landmarks_are_left_alone_and_those_without_a_partner_add_nothing(
    task: FitTask, true: dict[str, Array]
) -> None:
    both = {name: true[name] for name in ("suprasternal_notch", "umbilicus", "nipple_L", "nipple_R")}
    assert look(task.with_picks(both))[1] == {}
    for picks in (both, true):
        given = task.with_picks(picks)
        told, alone = (end(each) for each in (given, replace(given, recipe=silent(task.recipe))))
        np.testing.assert_array_equal(pose(task.rig, told.parameters), pose(task.rig, alone.parameters))


def test_no_pick_vouches_for_itself_by_its_partner(task: FitTask) -> None:
    """The posterior by which picks are judged is that of the picks alone; the fit's own knows of the partners."""
    last, names = end(task), tuple(sorted(PARTNERS))
    quiet = replace(task, recipe=silent(task.recipe))
    told, alone = (
        Posterior(ended(each, last), last.parameters, partners=False).landmark_variances(names)
        for each in (task, quiet)
    )
    np.testing.assert_array_equal(told, alone)
    assert (Posterior(ended(task, last), last.parameters).landmark_variances(names) < told).all()
