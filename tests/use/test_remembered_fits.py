"""What tests take for a fit that was made before is what that fit gave, and another job is fitted anew."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.remembered_fits import run_fit_once
from helpers.remembered_uploads import FOLDER
from helpers.toy_rig import toy_rig
from helpers.uploads import torso

from breastrig.gltf.write_rig import write_rig
from breastrig.use import fit as run_fit_module
from breastrig.use.steps.events import Event
from breastrig.use.steps.settings import FitJob


@pytest.fixture
def job(tmp_path: Path) -> FitJob:
    write_rig(toy_rig(), tmp_path / "model")
    (tmp_path / "scan.ply").write_bytes(torso())
    return FitJob(
        tmp_path / "scan.ply", tmp_path / "out", {"nipple_L": [1.0, 2.0, 3.0]}, model=tmp_path / "model/toy.glb"
    )


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The fits that are really made."""
    made: list[str] = []

    def one(job: FitJob) -> Iterator[Event]:
        made.append(job.preset)
        return fake_fit.quick(job)

    monkeypatch.setenv(FOLDER, str(tmp_path / "remembered"))
    monkeypatch.setattr(run_fit_module, "run_fit", one)
    return made


def into(job: FitJob, folder: Path) -> FitJob:
    folder.mkdir(parents=True)
    return replace(job, out=folder)


def files(job: FitJob) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in job.out.iterdir()}


def test_the_same_job_has_the_same_events_and_files_and_another_one_its_own(
    job: FitJob, made: list[str], tmp_path: Path
) -> None:
    first, again, other, scan = (into(job, tmp_path / name) for name in ("first", "again", "other", "scan"))
    events = list(run_fit_once(first))
    assert list(run_fit_once(again)) == events
    assert files(again) == files(first) != {}
    assert made == ["default"]
    list(run_fit_once(replace(other, preset="paper")))
    assert made == ["default", "paper"]
    scan.scan.write_bytes(torso() + b"\n")
    list(run_fit_once(scan))
    assert made == ["default", "paper", "default"]


def test_a_fit_that_was_broken_off_is_not_remembered(job: FitJob, made: list[str], tmp_path: Path) -> None:
    events = run_fit_once(into(job, tmp_path / "first"))
    next(events)
    events.close()  # type: ignore[attr-defined]
    list(run_fit_once(into(job, tmp_path / "again")))
    assert made == ["default", "default"]
