"""The worker's side of one fit: claim it, run it, store each event before anyone can see it.

Whatever goes wrong becomes the fit's last event with a sentence, unless the fit has been ended from outside
(cancelled, deleted) or another worker has claimed it: then the worker just stops.

A fit whose worker was lost with its machine or its server is started again, and its events go on where they stopped:
fits are deterministic, so the events that are stored already are only counted.
"""

import json
import logging
from collections.abc import Callable, Generator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import BadSettings, BreastRigError, NotFound
from breastrig.core.model_choice import ModelChoice
from breastrig.core.stances import Stance
from breastrig.service.events.event_writer import EventWriter, Superseded
from breastrig.storage.files import fit_place, scan_place, upload_name
from breastrig.storage.rows.events import event_of_kind
from breastrig.storage.rows.fits import FitRow, claim_fit, get_fit
from breastrig.storage.rows.scans import ScanRow, get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.events import Event, Failed
from breastrig.workflow.jobs import EarlierFit, FitJob, PredictionJob

Runner = Callable[[FitJob], Generator[Event, None, None]]
Predictor = Callable[[PredictionJob], Generator[Event, None, None]]


@dataclass(frozen=True)
class Runners:
    """The functions that run a fit and a prediction; importable by name in a worker."""

    fit: Runner
    prediction: Predictor


UNWRITTEN = "What this fit found could not be stored, perhaps because the server's disk was full; start the fit again."

UNSEEN = "The worker of this fit cannot reach the service's data folder; fits of a service need workers on its machine."
TOO_OFTEN = "This fit was started {} times without an end, as its server or worker ended first; start the fit again."
ATTEMPTS = 3  # one that takes its machine down with it must not do so for ever

log = logging.getLogger(__name__)


def execute_fit(root: Path, fit_id: str, runners: Runners, models: ModelChoice) -> None:
    """Runs the fit to its end; does nothing when it has ended.

    Holds the fit before the claim, so that whoever has ended it can wait until nothing more is written for it.
    """
    storage = Storage(root)
    try:
        if not storage.has_files():
            raise BadSettings(UNSEEN)
        with storage.held(fit_id):
            fit = claim_fit(storage, fit_id)
            if fit is not None:
                _run(storage, EventWriter(storage, fit), runners, models)
    except (FileNotFoundError, NotFound):
        log.info("fit %s was deleted before it ran", fit_id)
    except Superseded:
        pass
    finally:
        storage.close()


def _run(storage: Storage, writer: EventWriter, runners: Runners, models: ModelChoice) -> None:
    fit = writer.fit

    def fail(reason: str) -> None:
        with suppress(Superseded):
            writer.write(Failed(reason=reason))

    if fit.attempt > ATTEMPTS:
        fail(TOO_OFTEN.format(ATTEMPTS))
        return
    try:
        job = _job(storage, fit, storage.files.folder(fit_place(fit.id)), models)
        with closing(_events(runners, job)) as events:
            for event in events:
                writer.write(event)  # its files come before the event that says that they are there
    except BreastRigError as error:
        fail(str(error))
    except MemoryError:
        fail("The fit needed more memory than it may use; give a smaller scan.")
    except Superseded:
        raise
    except SQLAlchemyError:
        fail(UNWRITTEN)
    except OSError as error:
        log.error("fit %s met an error of the disk or the system: %s", fit.id, error.strerror)
        fail(UNWRITTEN)
    except Exception:
        log.exception("fit %s broke", fit.id)
        fail("The fit broke for a reason inside BreastRig; the server's log says it.")


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
    """A fit that is done, as its last iteration stands, to go on from."""
    earlier = get_fit(storage, fit_id)
    first = event_of_kind(storage, earlier.id, "started")
    last = event_of_kind(storage, earlier.id, "iterated", earlier.iterations - 1)
    assert first is not None
    assert last is not None
    return EarlierFit(earlier.stance, json.loads(last.json)["nodes"], json.loads(first.json)["model_sha256"])


def fit_job(scan: ScanRow, fit: FitRow, folder: Path, out: Path, model: Path | None) -> FitJob:
    """What the runner needs.  The unit is the one that was decided, and shown, at the upload."""
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
