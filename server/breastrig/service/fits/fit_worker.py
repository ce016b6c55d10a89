"""The worker's side of one fit: claim it, run it, store each event before anyone can see it.

Whatever goes wrong becomes the fit's last event with a sentence, unless the fit has been ended from outside
(cancelled, deleted) or another worker has claimed it: then the worker just stops.

A fit whose worker was lost with its machine or its server is started again, and its events go on where they stopped:
fits are deterministic, so the events that are stored already are only counted.
"""

import json
import logging
import shutil
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from breastrig.cases.fits import Claim, claimed
from breastrig.core.errors import BadSettings, BreastRigError, NotFound
from breastrig.core.model_choice import ModelChoice
from breastrig.core.stances import Stance
from breastrig.storage.documents.events import event_of_kind
from breastrig.storage.documents.fits import FitRow, get_fit
from breastrig.storage.documents.scans import ScanRow, get_scan
from breastrig.storage.files import fit_place, scan_place, upload_name
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import put_files
from breastrig.use.jobs import EarlierFit, FitJob, PredictionJob
from breastrig.use.steps.events import Event, Failed, event_json

Runner = Callable[[FitJob], Generator[Event, None, None]]
Predictor = Callable[[PredictionJob], Generator[Event, None, None]]


@dataclass(frozen=True)
class Runners:
    """The functions that run a fit and a prediction; importable by name in a worker."""

    fit: Runner
    prediction: Predictor


UNWRITTEN = "What this fit found could not be stored, perhaps because the server's disk was full; start the fit again."

UNSEEN = "The worker of this fit cannot reach the service's data folder; fits of a service need workers on its machine."
MADE = ".made"  # in the fit's folder

log = logging.getLogger(__name__)


def execute_fit(root: Path, fit_id: str, runners: Runners, models: ModelChoice) -> None:
    """Runs the fit to its end; does nothing when it has ended, or somebody else is at it."""
    storage = Storage(root)
    try:
        if not storage.has_files():
            raise BadSettings(UNSEEN)
        case, scan_id = storage.case_of_fit(fit_id)
        with claimed(case, scan_id, fit_id) as claim:
            if claim is not None:
                _run(storage, claim, runners, models)
    except (FileNotFoundError, NotFound):
        log.info("fit %s was deleted before it ran", fit_id)
    finally:
        storage.close()


def _run(storage: Storage, claim: Claim, runners: Runners, models: ModelChoice) -> None:
    fit_id = claim.fit_id
    try:
        with scratch_in(claim.folder) as made:
            job = _job(storage, get_fit(storage, fit_id), made, models)
            with closing(_events(runners, job)) as events:
                for event in events:
                    if event.kind == "done":
                        put_files(made, claim.folder)  # before the event that says that they are there
                    if not claim.append(event_json(event)):
                        return  # it was cancelled
    except NotFound:
        raise
    except BreastRigError as error:
        claim.end(_failed(str(error)))
    except MemoryError:
        claim.end(_failed("The fit needed more memory than it may use; give a smaller scan."))
    except OSError as error:
        log.error("fit %s met an error of the disk or the system: %s", fit_id, error.strerror)
        claim.end(_failed(UNWRITTEN))
    except Exception:
        log.exception("fit %s broke", fit_id)
        claim.end(_failed("The fit broke for a reason inside BreastRig; the server's log says it."))


def _failed(reason: str) -> dict[str, Any]:
    return event_json(Failed(reason=reason))


@contextmanager
def scratch_in(folder: Path) -> Iterator[Path]:
    """A folder of the fit for its files while they are made; what an earlier attempt has left there goes."""
    made = folder / MADE
    shutil.rmtree(made, ignore_errors=True)
    made.mkdir(mode=0o700)
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _events(runners: Runners, job: FitJob | PredictionJob) -> Generator[Event, None, None]:
    return runners.prediction(job) if isinstance(job, PredictionJob) else runners.fit(job)


def _job(storage: Storage, fit: FitRow, out: Path, models: ModelChoice) -> FitJob | PredictionJob:
    """The fit's task, with its scan at hand; of a prediction the fit that it comes from."""
    scan = get_scan(storage, fit.scan)
    model = models.of(scan.facts)
    if fit.predicted_from is not None:
        folder, stance = storage.files.folder(fit_place(fit.predicted_from)), cast(Stance, fit.asked_stance)
        return PredictionJob(folder, out, stance, fit.drawing, model)
    folder = storage.files.folder(scan_place(scan.id))
    earlier = None if fit.start_from is None else earlier_fit(storage, fit.start_from)
    return replace(fit_job(scan, fit, folder, out, model), earlier=earlier)


def earlier_fit(storage: Storage, fit_id: str) -> EarlierFit:
    """A finished fit at its last iteration, to continue from."""
    earlier = get_fit(storage, fit_id)
    first = event_of_kind(storage, earlier.id, "started")
    last = event_of_kind(storage, earlier.id, "iterated", earlier.iterations - 1)
    assert first is not None
    assert last is not None
    return EarlierFit(earlier.stance, json.loads(last.json)["nodes"], json.loads(first.json)["model_sha256"])


def fit_job(scan: ScanRow, fit: FitRow, folder: Path, out: Path, model: Path | None) -> FitJob:
    """The runner's job. The unit is the one that was decided, and shown, at the upload."""
    return FitJob(
        scan=folder / upload_name(scan.file_type),
        out=out,
        landmarks_mm=fit.landmarks_mm,
        certain=fit.certain,
        landmark_confidence=fit.confidence,
        units=scan.facts["unit"],
        file_type=scan.file_type,
        stance=fit.asked_stance,
        preset=fit.preset,
        drawing=fit.drawing,
        model=model,
        refine=fit.refine,
        orientation=None if fit.cuts else scan.facts.get("orientation"),  # that is of the whole scan
        cuts=fit.cuts,
    )
