"""A prediction as a stream of events, from files to files, as use/fit.py has fits.

Whoever stops consuming the generator cancels it; nothing is written then.
"""

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

from breastrig.core.private_files import write_files
from breastrig.core.stances import Stance
from breastrig.files.result import RESULT, parsed_result, read_result
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.use.predictions.predict import prediction
from breastrig.use.steps.events import Done, Event, Started


@dataclass(frozen=True)
class PredictionJob:
    """A stance that was not scanned, from files to files."""

    fit: Path  # folder of a fit
    out: Path
    stance: Stance
    drawing: str | None = None  # that the fit was asked for
    model: Path | None = None  # None: the torso of the package


def run_prediction(job: PredictionJob) -> Generator[Event, None, None]:
    """Started, Done; a BreastRigError instead when it cannot be done.

    Writes the files of a fit before Done.
    """
    rig, given = read_rig(job.model or default_rig_path()), read_result(job.fit)
    yield Started(
        stance=job.stance,
        stance_reason=f"It was asked for; the scan is {given.stance}.",
        preset=given.preset,
        model_sha256=rig.sha256,
        drawing=job.drawing,
        iterations_limit=0,
    )
    files = prediction(rig, job.fit, job.stance)
    write_files(files, job.out)
    yield Done(result=parsed_result(files[RESULT], job.fit.name))
