"""Picks are believed: only mistakes with a name are let go, what is strange is named, what is certain is not asked."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import FitIterate, without
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


def task_of(rig: Rig, seed: int, picks: dict[str, Array], true: dict[str, Array]) -> FitTask:
    target, _, _ = patient(rig, seed)
    return FitTask(rig, target, start_from_landmarks(rig, true), load_recipe("default"), {}).with_picks(picks)


def named(task: FitTask, last: FitIterate) -> list[tuple[str, ...]]:
    return [doubt.names for doubt in unusual(Posterior(without(task, last.not_followed), last.parameters))]


def gap(rig: Rig, last: FitIterate, name: str, place: Array) -> float:
    point = rig.landmark_points((name,)).positions(pose(rig, last.parameters), rig.faces)[0]
    return float(np.linalg.norm(point - place))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "away"),
    [
        ("acromion_L", [0.05, -0.08, 0.0]),
        ("inframammary_fold_L", [0.05, 0.0, 0.0]),
    ],
)
def test_a_pick_far_off_is_followed_and_named(torso: Rig, name: str, away: list[float]) -> None:
    target, true, _ = patient(torso, 5)
    far = true | {name: target.search.query((true[name] + away)[None]).points[0]}
    task = task_of(torso, 5, far, true)
    iterates = list(checked_iterates(task))
    last = iterates[-1]
    assert last.not_followed == ()
    assert named(task, last) == [(name,)], "nor any of its neighbours, which it pushes"
    moved = float(np.linalg.norm(far[name] - true[name]))
    assert moved > 0.035
    assert gap(torso, last, name, far[name]) < 0.6 * moved, "it follows the person as far as the skin allows"
    assert [iterate.iteration for iterate in iterates] == list(range(len(iterates)))
    assert all(iterate.status is Status.RUNNING for iterate in iterates[:-1])
    elapsed = [iterate.elapsed_s for iterate in iterates]
    assert elapsed == sorted(elapsed)


def test_a_pick_that_the_model_expected_elsewhere_is_followed_where_the_body_is_unusual(torso: Rig) -> None:
    """A navel 25 mm higher than the body would have it: the person is right."""
    target, true, _ = patient(torso, 4)
    picks = true | {"umbilicus": target.search.query((true["umbilicus"] + [0.0, 0.025, 0.0])[None]).points[0]}
    last = list(checked_iterates(task_of(torso, 4, picks, true)))[-1]
    assert last.not_followed == ()
    assert gap(torso, last, "umbilicus", picks["umbilicus"]) < 0.006


@pytest.mark.slow
def test_exchanged_partners_are_rejected_together_and_leave_the_rest_right(torso: Rig) -> None:
    _, true, _ = patient(torso, 5)
    wrong = true | {"nipple_L": true["nipple_R"], "nipple_R": true["nipple_L"]}
    last = list(checked_iterates(task_of(torso, 5, wrong, true)))[-1]
    (doubt,) = last.not_followed
    assert doubt.names == ("nipple_L", "nipple_R")
    assert "exchanged" in doubt.reason
    assert not doubt.followed
    assert max(gap(torso, last, name, place) for name, place in true.items()) < 0.02


def test_a_pick_on_another_landmarks_place_is_rejected_with_its_name(torso: Rig) -> None:
    _, true, _ = patient(torso, 5)
    wrong = {name: place for name, place in true.items() if name != "nipple_L"}
    wrong["nipple_R"] = true["nipple_L"] + [0.004, 0.0, 0.0]
    last = list(checked_iterates(task_of(torso, 5, wrong, true)))[-1]
    (doubt,) = last.not_followed
    assert doubt.names == ("nipple_R",)
    assert "where nipple_L is expected" in doubt.reason


@pytest.mark.slow
def test_at_most_a_third_is_rejected(torso: Rig) -> None:
    _, true, _ = patient(torso, 5)
    sides = [name[:-2] for name in true if name.endswith("_L")]
    wrong = dict(true)
    for side in sides[:3]:
        wrong[f"{side}_L"], wrong[f"{side}_R"] = true[f"{side}_R"], true[f"{side}_L"]
    last = list(checked_iterates(task_of(torso, 5, wrong, true)))[-1]
    assert sum(len(doubt.names) for doubt in last.not_followed) <= len(true) // 3


@pytest.mark.slow
def test_without_picks_nothing_is_asked(torso: Rig) -> None:
    _, true, _ = patient(torso, 1)
    task = task_of(torso, 1, {}, true)
    plain, checked = list(fit_iterates(task)), list(checked_iterates(task))
    assert len(plain) == len(checked)
    np.testing.assert_array_equal(plain[-1].parameters.weights, checked[-1].parameters.weights)
    assert named(task, checked[-1]) == []
