"""The worker's side of one fit: claim it, run it, store each event before anyone can see it.

Whatever goes wrong becomes the fit's last event with a sentence, unless the fit has been ended from outside
(cancelled, deleted) or another worker has claimed it: then the worker just stops.

A fit whose worker was lost with its machine or its server is started again, and its events go on where they stopped:
fits are deterministic, so the events that are stored already are only counted.
"""

import logging
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from breastrig.cases.fits import Claim, claimed
from breastrig.core.errors import BadSettings, BreastRigError, NotFound
from breastrig.core.model_choice import ModelChoice
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import Runners, stored_events
from breastrig.use.steps.events import Failed, event_json

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
                _run(claim, runners, models)
    except (FileNotFoundError, NotFound):
        log.info("fit %s was deleted before it ran", fit_id)
    finally:
        storage.close()


def _run(claim: Claim, runners: Runners, models: ModelChoice) -> None:
    fit_id = claim.fit_id
    try:
        with scratch_in(claim.folder) as made:
            model = models.of(claim.case.scan(claim.scan_id).facts)
            for _ in stored_events(claim, made, model, runners):
                pass  # who follows the fit reads them from its log
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
