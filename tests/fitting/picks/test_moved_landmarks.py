"""A finished fit follows dragged landmarks, and ends where a fit from the beginning ends."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.example_fit import example_task

from breastrig.core.arrays import Array
from breastrig.fitting.picks.moved_landmarks import ITERATIONS, FittedScan
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.task import FitTask
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose


@pytest.fixture(scope="module")
def fitted() -> FitTask:
    """The example patient, and where the model lies on her."""
    task = example_task()
    *_, last = checked_iterates(task)
    return replace(task, start=last.parameters)


def apart_mm(task: FitTask, one: RigParameters, other: RigParameters) -> Array:
    return np.asarray(1e3 * np.linalg.norm(pose(task.rig, one) - pose(task.rig, other), axis=1))


@pytest.mark.slow
def test_the_end_of_a_drag_is_where_a_fresh_fit_ends(fitted: FitTask) -> None:
    scan, name, way = FittedScan(fitted), "nipple_L", (0.012, 0.012, 0.004)
    for share in np.linspace(0.1, 1.0, 7):
        moved = {**fitted.landmarks, name: fitted.landmarks[name] + share * np.array(way)}
        last = scan.moved(moved)
        assert last.iteration <= ITERATIONS
    *_, fresh = checked_iterates(example_task().with_picks(moved))
    assert apart_mm(fitted, last.parameters, fresh.parameters).mean() < 0.3
    at_rest = FittedScan(replace(fitted, start=fresh.parameters))  # a fit stops up to 0.1 mm before its own end
    for _ in range(5):
        end = at_rest.moved(moved)
    assert apart_mm(fitted, last.parameters, end.parameters).mean() < 0.25
    assert apart_mm(fitted, fitted.start, fresh.parameters).max() > 2.0  # it did move
    assert scan.task.start is last.parameters


def test_a_drag_back_ends_where_it_began(fitted: FitTask) -> None:
    scan = FittedScan(fitted)
    away = {**fitted.landmarks, "nipple_L": fitted.landmarks["nipple_L"] + [0.0, 0.02, 0.0]}
    for landmarks in (away, away, fitted.landmarks, fitted.landmarks):
        last = scan.moved(landmarks)
    assert apart_mm(fitted, last.parameters, fitted.start).mean() < 0.1


def test_landmarks_that_break_the_fit_leave_the_model_where_it_was(fitted: FitTask) -> None:
    scan = FittedScan(fitted)
    last = scan.moved({name: np.add(place, [0.0, 0.0, 5.0]) for name, place in fitted.landmarks.items()})
    assert not last.is_finite
    assert scan.task.start is fitted.start
    assert scan.moved(fitted.landmarks).is_finite


def test_a_model_that_picks_have_torn_off_the_scan_comes_back_to_it(fitted: FitTask) -> None:
    scan = FittedScan(fitted)
    there = scan.moved(fitted.landmarks)
    torn = scan.moved({name: np.add(place, [0.0, 0.0, 0.2]) for name, place in fitted.landmarks.items()})
    assert apart_mm(fitted, torn.parameters, there.parameters).mean() > 20.0
    back = scan.moved(fitted.landmarks)
    assert apart_mm(fitted, back.parameters, there.parameters).mean() < 0.1
