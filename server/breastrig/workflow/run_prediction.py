"""A prediction as a stream of events, from files to files, as run_fit.py has fits."""

from collections.abc import Generator

from breastrig.core.private_files import write_files
from breastrig.files.result import RESULT, parsed_result
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.workflow.events import Done, Event, Started
from breastrig.workflow.jobs import PredictionJob
from breastrig.workflow.predict import predicted_files


def run_prediction(job: PredictionJob) -> Generator[Event, None, None]:
    """Started and Done; a BreastRigError instead when it cannot be done.  Writes the files of a fit before Done."""
    rig = read_rig(job.model or default_rig_path())
    files = predicted_files(rig, job.fit, job.stance)
    result = parsed_result(files[RESULT], job.fit.name)
    yield Started(
        stance=result.stance,
        stance_reason=result.stance_reason,
        preset=result.preset,
        model_sha256=rig.sha256,
        drawing=job.drawing,
        iterations_limit=0,
    )
    write_files(files, job.out)
    yield Done(result=result)
