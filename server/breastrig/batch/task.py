"""One fit of a batch in a worker: bytes in, bytes out, so that a worker needs no disk in common with anyone.

Only large images are read by the workers of this machine themselves.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.batch.table import MEASURES
from breastrig.core.arrays import Array
from breastrig.core.assets import model_path
from breastrig.core.picks import Picks
from breastrig.core.private_files import write_private
from breastrig.core.scratch import scratch_folder
from breastrig.scan.landmarks.landmark_files import landmarks_of_file
from breastrig.scan.read import read_scan
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers
from breastrig.use.fit import run_fit
from breastrig.use.reports.report import ReportJob, measures_csv_of
from breastrig.use.steps.events import Event
from breastrig.use.steps.settings import FitJob, FitSettings

Runner = Callable[[FitJob], Iterator[Event]]


@dataclass(frozen=True, repr=False)
class FitOfBytes:
    """The inputs of `breastrig fit`, with the files' contents in the place of their names."""

    scan: bytes | Path  # the path where the worker has the same disk, of a zip or folder that may be an MRI
    ending: str  # of the scan's name, as in .ply
    landmarks: bytes | None
    landmarks_ending: str
    settings: FitSettings
    preset_file: bytes | None = None  # a preset of the user's own
    units: str = "auto"
    model: str | None = None  # a packaged one's name or a path on this machine; None: the torso
    prior: bytes | None = None  # a file of `breastrig cohort`
    answers: VolumeAnswers = NOTHING_SAID  # of a label map
    lesions: tuple[bytes, ...] = ()  # files of lesions that lie in the image

    def picks(self) -> Picks:
        """The landmarks; those without a unit of their own have the scan's."""
        if self.landmarks is None:
            return Picks()
        return landmarks_of_file(self.landmarks, self._measured, self.landmarks_ending)

    def _measured(self) -> tuple[float, tuple[Array, Array]]:
        answers = self.answers.without_lesions if self.lesions else self.answers
        return read_scan(self.scan, self.ending, self.units, texture=False, answers=answers).measured


def measured_fit(job: FitJob) -> Iterator[Event]:
    """A fit with its table of measures beside its files."""
    yield from run_fit(job)
    write_private(job.out / MEASURES, measures_csv_of(ReportJob(job.out, model=job.model)))


def fit_of_bytes(task: FitOfBytes, runner: Runner) -> dict[str, bytes]:
    """The files that a fit leaves, by name.  Raises a BreastRigError when it cannot be done."""
    with scratch_folder() as folder:
        scan = folder / f"scan{task.ending}" if isinstance(task.scan, bytes) else task.scan
        if isinstance(task.scan, bytes):
            scan.write_bytes(task.scan)
        picks = task.picks()
        own: dict[str, Any] = {
            "landmark_confidence": picks.confidence,
            "certain": picks.certain,
            "marks_mm": picks.marks_mm,
            "open_names": picks.open_names,
        }
        if task.preset_file is not None:
            (folder / "preset.toml").write_bytes(task.preset_file)
            own["preset"] = str(folder / "preset.toml")
        job = FitJob(
            scan=scan,
            out=folder / "out",
            landmarks_mm=picks.points_mm,
            units=task.units,
            model=None if task.model is None else model_path(task.model),
            prior=task.prior,
            answers=task.answers,
            lesions=task.lesions,
            **vars(task.settings) | own,
        )
        for _ in runner(job):
            pass  # the files say it all
        return {file.name: file.read_bytes() for file in sorted(job.out.iterdir())}
