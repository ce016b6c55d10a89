"""The worker's side of one fit: claim it, run it, store each event before anyone can see it.

Whatever goes wrong becomes the fit's last event with a sentence, unless the fit has been ended from outside
(cancelled, deleted) or another worker has claimed it: then the worker just stops.

A fit whose worker was lost with its machine or its server is started again, and its events go on where they stopped:
fits are deterministic, so the events that are stored already are only counted.
"""

import json
import logging
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import BadSettings, BreastRigError, NotFound
from breastrig.core.model_choice import ModelChoice
from breastrig.core.scratch import scratch_folder
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
PairRunner = Callable[[FitJob, FitJob], Generator[tuple[int, Event], None, None]]
Predictor = Callable[[PredictionJob], Generator[Event, None, None]]


@dataclass(frozen=True)
class Runners:
    """The functions that run one fit, two stances together, and a prediction; importable by name in a worker."""

    one: Runner
    two: PairRunner
    prediction: Predictor


UNWRITTEN = "What this fit found could not be stored, perhaps because the server's disk was full; start the fit again."

UNSEEN = "The worker of this fit cannot reach the service's data folder; fits of a service need workers on its machine."
TOO_OFTEN = "This fit was started {} times without an end, as its server or worker ended first; start the fit again."
ATTEMPTS = 3  # one that takes its machine down with it must not do so for ever

log = logging.getLogger(__name__)


def execute_fit(root: Path, fit_id: str, runners: Runners, models: ModelChoice) -> None:
    """Runs the fit, and its partner with it, to the end; does nothing when both have ended.

    Holds the fits before the claim, so that whoever has ended one can wait until nothing more is written for it.
    """
    storage = Storage(root)
    try:
        if not storage.has_files():
            raise BadSettings(UNSEEN)
        with ExitStack() as stack:
            for each in get_fit(storage, fit_id).both:
                stack.enter_context(storage.held(each))
            fit = claim_fit(storage, fit_id)
            if fit is not None:
                both = [fit, *(get_fit(storage, each) for each in fit.both[1:])]
                _run(storage, [EventWriter(storage, each) for each in both], runners, models)
    except (FileNotFoundError, NotFound):
        log.info("fit %s was deleted before it ran", fit_id)
    except Superseded:
        pass
    finally:
        storage.close()


def _run(storage: Storage, writers: list[EventWriter], runners: Runners, models: ModelChoice) -> None:
    first = writers[0].fit

    def fail(reason: str) -> None:
        for each in writers:
            with suppress(Superseded):
                each.write(Failed(reason=reason))

    if max(each.fit.attempt for each in writers) > ATTEMPTS:
        fail(TOO_OFTEN.format(ATTEMPTS))
        return
    try:
        with ExitStack() as stack:
            outs = [stack.enter_context(_out(storage, each.fit)) for each in writers]
            jobs = [_job(storage, each.fit, out, models) for each, out in zip(writers, outs, strict=True)]
            for which, event in stack.enter_context(closing(_events(runners, jobs))):
                writers[which].write(event)  # its files come before the event that says that they are there
    except BreastRigError as error:
        fail(str(error))
    except MemoryError:
        fail("The fit needed more memory than it may use; give a smaller scan.")
    except Superseded:
        raise
    except SQLAlchemyError:
        fail(UNWRITTEN)
    except OSError as error:
        log.error("fit %s met an error of the disk or the system: %s", first.id, error.strerror)
        fail(UNWRITTEN)
    except Exception:
        log.exception("fit %s broke", first.id)
        fail("The fit broke for a reason inside BreastRig; the server's log says it.")


def _events(runners: Runners, jobs: list[FitJob | PredictionJob]) -> Generator[tuple[int, Event], None, None]:
    """(0, or 1 for the partner, and its next event)."""
    match jobs:
        case FitJob() as first, FitJob() as second:
            with closing(runners.two(first, second)) as pairs:
                yield from pairs
        case (job, *_):
            with closing(runners.prediction(job) if isinstance(job, PredictionJob) else runners.one(job)) as events:
                for event in events:
                    yield 0, event


@contextmanager
def _out(storage: Storage, fit: FitRow) -> Iterator[Path]:
    """Where the fit's files are written; those of one that has ended already lead nowhere."""
    if fit.ended:
        with scratch_folder() as folder:
            yield folder
        return
    yield storage.files.folder(fit_place(fit.id))


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
