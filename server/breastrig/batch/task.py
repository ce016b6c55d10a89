"""One fit of a batch in a worker: bytes in, bytes out, so that a worker needs no disk in common with anyone."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from breastrig.batch.table import MEASURES
from breastrig.core.private_files import write_private
from breastrig.core.scratch import scratch_folder
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.landmarks.landmark_files import (
    certain_landmarks,
    landmark_confidences,
    metres_per_unit,
    read_landmarks,
)
from breastrig.scan.read import read_scan
from breastrig.workflow.events import Event
from breastrig.workflow.jobs import FitJob, ReportJob
from breastrig.workflow.report import measures_csv_of
from breastrig.workflow.run_fit import run_fit

Runner = Callable[[FitJob], Iterator[Event]]


@dataclass(frozen=True, repr=False)
class FitOfBytes:
    """What `breastrig fit` is given, with the files' contents in the place of their names."""

    scan: bytes
    ending: str  # of the scan's name, as in .ply
    landmarks: bytes | None
    landmarks_ending: str
    units: str
    stance: str
    preset: str
    preset_file: bytes | None  # a preset of the user's own
    drawing: str | None
    refine: bool

    def landmarks_mm(self) -> dict[str, list[float]]:
        """The picks in mm; those without a unit of their own have the scan's."""
        if self.landmarks is None:
            return {}
        places, unit = read_landmarks(self.landmarks, self.landmarks_ending)
        if unit:
            metres = METRES_PER_UNIT[unit]
        else:
            scan = read_scan(self.scan, self.ending, self.units, texture=False)
            metres = metres_per_unit(places, unit, scan.metres_per_unit, scan.bounds)
        return {name: [1e3 * metres * float(value) for value in place] for name, place in places.items()}


def measured_fit(job: FitJob) -> Iterator[Event]:
    """A fit with its table of measures beside its files."""
    yield from run_fit(job)
    write_private(job.out / MEASURES, measures_csv_of(ReportJob(job.out, model=job.model)))


def fit_of_bytes(task: FitOfBytes, runner: Runner) -> dict[str, bytes]:
    """The files that a fit leaves, by name.  Raises a BreastRigError when it cannot be done."""
    with scratch_folder() as folder:
        scan = folder / f"scan{task.ending}"
        scan.write_bytes(task.scan)
        preset = task.preset
        if task.preset_file is not None:
            preset = str(folder / "preset.toml")
            (folder / "preset.toml").write_bytes(task.preset_file)
        job = FitJob(
            scan=scan,
            out=folder / "out",
            landmarks_mm=task.landmarks_mm(),
            landmark_confidence=landmark_confidences(task.landmarks) if task.landmarks is not None else {},
            certain=certain_landmarks(task.landmarks) if task.landmarks is not None else (),
            units=task.units,
            stance=task.stance,
            preset=preset,
            drawing=task.drawing,
            refine=task.refine,
        )
        for _ in runner(job):
            pass  # the files say it all
        return {file.name: file.read_bytes() for file in sorted(job.out.iterdir())}
