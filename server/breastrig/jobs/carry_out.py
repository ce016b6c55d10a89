"""The worker's side of one fit: claim it, run it, store each event before anyone can see it.

Whatever goes wrong becomes the story's last event with a sentence, unless the story has been ended from outside
(cancelled, deleted): then the worker just stops.
"""

import logging
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import BreastRigError, Conflict, NotFound
from breastrig.jobs.events import Event, Failed
from breastrig.jobs.run_fit import FitJob
from breastrig.storage.events import append
from breastrig.storage.fits import FitRow, claim_fit, get_fit
from breastrig.storage.scans import get_scan
from breastrig.storage.storage import Storage

Runner = Callable[[FitJob], Iterator[Event]]
PairRunner = Callable[[FitJob, FitJob], Iterator[tuple[int, Event]]]


@dataclass(frozen=True)
class Runners:
    """How a fit is carried out, and how two stances together; both importable by name in a worker process."""

    one: Runner
    two: PairRunner


UNWRITTEN = "What this fit found could not be stored, perhaps because the server's disk was full; start the fit again."

log = logging.getLogger(__name__)


class _Over(Exception):
    """The story has been ended by someone else."""


def carry_out(root: Path, fit_id: str, runners: Runners, model: Path | None) -> None:
    """Runs the queued fit, and its partner with it, to the end; does nothing when it is no longer queued.

    Holds the folders before the claim, so that whoever has ended the fit can wait until nothing more is written
    into them.
    """
    storage = Storage(root)
    try:
        with ExitStack() as stack:
            for each in get_fit(storage, fit_id).both:
                stack.enter_context(storage.folders.held(storage.folders.fit(each)))
            fit = claim_fit(storage, fit_id)
            if fit is not None:
                _run(storage, fit, runners, model)
    except (FileNotFoundError, NotFound):
        log.info("fit %s was deleted before it ran", fit_id)
    except _Over:
        pass
    finally:
        storage.close()


def _run(storage: Storage, fit: FitRow, runners: Runners, model: Path | None) -> None:
    def fail(reason: str) -> None:
        for each in fit.both:
            with suppress(_Over):  # the first of two may be done already
                store(storage, each, Failed(reason=reason))

    try:
        with closing(_story(storage, fit, runners, model)) as story:
            for fit_id, event in story:
                store(storage, fit_id, event)
    except BreastRigError as error:
        fail(str(error))
    except MemoryError:
        fail("The fit needed more memory than it may use; give a smaller scan.")
    except _Over:
        raise
    except SQLAlchemyError:
        fail(UNWRITTEN)
    except OSError as error:
        log.error("fit %s met an error of the disk or the system: %s", fit.id, error.strerror)
        fail(UNWRITTEN)
    except Exception:
        log.exception("fit %s broke", fit.id)
        fail("The fit broke for a reason inside BreastRig; the server's log says it.")


def _story(
    storage: Storage, fit: FitRow, runners: Runners, model: Path | None
) -> Generator[tuple[str, Event], None, None]:
    """(id of the fit, its next event)."""
    job = fit_job(storage, fit, model)
    if fit.partner is None:
        with closing(runners.one(job)) as events:  # type: ignore[type-var]
            for event in events:
                yield fit.id, event
        return
    other = fit_job(storage, get_fit(storage, fit.partner), model)
    with closing(runners.two(job, other)) as pairs:  # type: ignore[type-var]
        for which, event in pairs:
            yield fit.both[which], event


def fit_job(storage: Storage, fit: FitRow, model: Path | None) -> FitJob:
    """What the runner is told.  The unit is the one that was decided, and shown, at the upload."""
    scan = get_scan(storage, fit.scan)
    return FitJob(
        scan=storage.folders.uploaded(scan.id, scan.file_type),
        out=storage.folders.fit(fit.id),
        landmarks_mm=fit.landmarks_mm,
        units=scan.facts["unit"],
        file_type=scan.file_type,
        stance=fit.stance,
        preset=fit.preset,
        drawing=fit.drawing,
        model=model,
        refine=fit.refine,
    )


def store(storage: Storage, fit_id: str, event: Event) -> int:
    """Appends one event; its number.  Raises _Over when the story has ended or is gone."""
    try:
        return append(storage, fit_id, event_json(event))
    except (NotFound, Conflict) as error:
        raise _Over from error


def event_json(event: Event) -> dict[str, Any]:
    """The event as it is stored and sent; a node names only what changes."""
    body = event.model_dump(mode="json")
    if "nodes" in body:
        body["nodes"] = [{key: value for key, value in node.items() if value is not None} for node in body["nodes"]]
    return body
