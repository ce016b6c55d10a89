"""Picks that cannot be right are named in the events, as soon as the fit knows."""

from pathlib import Path

import pytest
import trimesh

from breastrig.core.assets import asset_folder
from breastrig.core.clock import Clock
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.use.fit import run_fit
from breastrig.use.steps.events import Done, Started
from breastrig.use.steps.outcome import started
from breastrig.use.steps.prepare import fit_plan, prepare_fit, read_model, scan_of_job
from breastrig.use.steps.settings import FitJob

EXAMPLE = asset_folder("example") / "standing"
OTHER_SIDE = {"_L": "_R", "_R": "_L"}


def events(landmarks: dict[str, list[float]], out: Path) -> tuple[Started, Done]:
    first, *_, last = run_fit(FitJob(scan=EXAMPLE / "scan.ply", out=out, landmarks_mm=landmarks))
    assert isinstance(first, Started)
    assert isinstance(last, Done)
    return first, last


@pytest.fixture
def picks() -> dict[str, list[float]]:
    places, unit = read_landmarks(EXAMPLE / "landmarks.json")
    assert unit == "mm"
    return {name: [float(value) for value in place] for name, place in places.items()}


@pytest.mark.slow
@pytest.mark.parametrize("middle", [("umbilicus",)])
def test_of_few_picks_the_skin_tells(picks, middle, tmp_path: Path) -> None:
    """Three lie in one plane, whatever their sides."""
    few = {name: picks[name] for name in ("nipple_L", "nipple_R", *middle)}
    [doubt] = first_event(FitJob(EXAMPLE / "scan.ply", tmp_path, exchanged_sides(few))).landmarks_not_followed
    assert sorted(doubt.names) == sorted(few)
    assert first_event(FitJob(EXAMPLE / "scan.ply", tmp_path, few)).landmarks_not_followed == []


def first_event(job: FitJob) -> Started:
    return started(prepare_fit(fit_plan(job, read_model(job), job.landmarks_mm), scan_of_job(job), Clock()))


def exchanged_sides(picks: dict[str, list[float]]) -> dict[str, list[float]]:
    return {name[:-2] + OTHER_SIDE.get(name[-2:], name[-2:]): place for name, place in picks.items()}


def test_sides_that_a_person_is_certain_of_are_not_called_exchanged(picks, tmp_path: Path) -> None:
    exchanged = exchanged_sides(picks)
    certain = tuple(exchanged)
    job = FitJob(scan=EXAMPLE / "scan.ply", out=tmp_path, landmarks_mm=exchanged, certain=certain)
    first = next(run_fit(job))
    assert isinstance(first, Started)
    assert first.landmarks_not_followed == []


@pytest.mark.slow
def test_a_certain_pick_of_the_middle_is_followed_when_all_sides_are_exchanged(picks, tmp_path: Path) -> None:
    exchanged = exchanged_sides(picks)
    job = FitJob(scan=EXAMPLE / "scan.ply", out=tmp_path, landmarks_mm=exchanged, certain=("umbilicus",))
    ready = prepare_fit(fit_plan(job, read_model(job), job.landmarks_mm), scan_of_job(job), Clock())
    [doubt] = started(ready).landmarks_not_followed
    assert doubt.names == [name for name in exchanged if name != "umbilicus"]
    assert list(ready.hypothesis.task.picked) == ["umbilicus"]
    assert ready.hypothesis.task.certain & set(ready.hypothesis.task.picked) == {"umbilicus"}


def test_few_right_picks_on_a_scan_that_is_inside_out_are_not_called_exchanged(picks, tmp_path: Path) -> None:
    """Which way skin faces is asked of the scan as it was cleaned."""
    scan = trimesh.load(EXAMPLE / "scan.ply", process=False)
    trimesh.Trimesh(scan.vertices, scan.faces[:, ::-1], process=False).export(tmp_path / "scan.ply")
    few = {name: picks[name] for name in ("nipple_L", "nipple_R", "umbilicus")}
    job = FitJob(scan=tmp_path / "scan.ply", out=tmp_path, landmarks_mm=few)
    assert first_event(job).landmarks_not_followed == []
