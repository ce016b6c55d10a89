"""The service behind HTTP: scans kept, fits run, their events followed.

with Service(storage, runner).started() as service: ...

owns the pool of processes, the queue and the notifier; `started` starts all and leaves nothing running. Another
executor may run the fits; it is the service's then.

A process stays a while for each scan in work and for each fit on which something is moved: it has read it already.
Pairs, transfers and reports read more than one, so each has a process of its own.
"""

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from breastrig.audit.log import AuditLog, Entry
from breastrig.cases.documents import FitDocument
from breastrig.cases.lengths import End
from breastrig.core.errors import NotFound, NotRemoved
from breastrig.core.model_choice import model_choice
from breastrig.core.stances import Stance
from breastrig.execution.executor import Executor
from breastrig.execution.limits import FitLimits, UploadLimits
from breastrig.execution.pool import Pool
from breastrig.execution.worker import preload
from breastrig.service.bring_over import take_over
from breastrig.service.events.feeds import Notifier, StreamItem, follow
from breastrig.service.failed_tasks import explained
from breastrig.service.fits.queue import FitQueue, WaitingCap
from breastrig.service.kept_models import KeptModels
from breastrig.service.line_checks import LineChecks
from breastrig.service.moving import Moving
from breastrig.service.plans import Plans
from breastrig.service.readiness import Readiness
from breastrig.service.reports import Reports
from breastrig.service.scans.scan_search import InkSearch, Proposals, Proposer
from breastrig.service.scans.skin_checks import SkinChecks
from breastrig.service.scans.uploads import Uploads
from breastrig.service.share_snapshots import ShareSnapshots
from breastrig.service.sweep import KEEP_DAYS, Sweep
from breastrig.service.task_modules import TASK_MODULES
from breastrig.service.visits import Visits
from breastrig.storage.deletion import delete_empty_case, delete_scan, finish_deletions
from breastrig.storage.documents.fits import Once, StoredFit, add_fit, fits_of_scan, get_fit, made_before
from breastrig.storage.documents.patients import said_same, scans_of_patient
from breastrig.storage.documents.scans import get_cuts, get_landmarks, get_scan, put_length
from breastrig.storage.files import fit_place, scan_place, upload_name
from breastrig.storage.folders import new_id
from breastrig.storage.storage import Storage, Unremoved
from breastrig.use.cases.case_work import Predictor, Runner, Runners, asked_prediction
from breastrig.use.fit import run_fit
from breastrig.use.landmarks import propose_on_file
from breastrig.use.marks.propose_marks import MarksJob, ScanFile, propose_marks_on_files
from breastrig.use.predict import run_prediction
from breastrig.use.transfer import carried_between

INTERACTIVE = 4  # patterns or landmarks that are moved at once
IDLE = 8  # processes that rest: of a patient's two scans and their fits, each some hundred megabytes
TRANSFER_WALL_S = 180.0  # a transfer takes a second or two; a slow or busy machine with huge scans may take many
MARKS_WALL_S = 90.0  # two textures of 4096 take ten seconds, on a busy machine many

log = logging.getLogger(__name__)


class Service:
    """One data folder at work."""

    def __init__(
        self,
        storage: Storage,
        *,
        runner: Runner = run_fit,
        predictor: Predictor = run_prediction,
        proposer: Proposer = propose_on_file,
        model: Path | None = None,
        examples: Path | None = None,
        uploads: UploadLimits | None = None,
        fits: FitLimits | None = None,
        executor: Executor | None = None,
        streams: int = 24,
        keep_days: float | None = KEEP_DAYS,
    ) -> None:
        self.storage = storage
        self.audit = AuditLog(storage.root)
        self.streams = threading.BoundedSemaphore(streams)
        limits = uploads or UploadLimits()
        fit_limits = fits or FitLimits()
        preload(TASK_MODULES)
        self.pool = Pool(IDLE)
        self._readers, self._others, interactive = (
            self.pool.queue(places, limits.memory_bytes, limits.waiting_per_client)
            for places in (limits.workers, limits.workers, INTERACTIVE)
        )
        self._workers = executor or self.pool.queue(fit_limits.workers, fit_limits.memory_bytes)
        runners = Runners(runner, predictor)
        self._choice = model_choice(model)
        self._queue = FitQueue(storage, self._workers, fit_limits, runners, self._choice)
        self.readiness = Readiness(storage, {"read uploads": self._readers, "fit": self._workers})
        self._waiting = WaitingCap(storage, fit_limits.waiting_per_client)
        self.proposals = Proposals(storage, self._others, limits.wall_s, proposer, self._choice)
        self.ink = InkSearch(storage, self._others, limits.wall_s)
        self.models = KeptModels(storage, model)
        self.plans = Plans(storage, self._others, self.models)
        self.moving = Moving(storage, interactive, self.models)
        self.skin_checks = SkinChecks(storage, interactive)
        self.line_checks = LineChecks(storage, interactive, self.plans, self.models)
        self.reports = Reports(storage, self._others, self.plans, self.models)
        self.visits = Visits(storage, self._others, self.models)
        self.shares = ShareSnapshots(storage, self._others, self.plans, self.reports, self.models)
        self._notifier = Notifier(storage)
        self._sweep = Sweep(storage, self.delete_scan, keep_days, self.shares.end_expired, self.audit)
        self.uploads = Uploads(storage, self._readers, limits, self.models, self._choice, examples)

    @contextmanager
    def started(self) -> Iterator["Service"]:
        """Holds the data folder, starts the processes, takes up what an earlier server left; stops all at the end."""
        with self.storage.exclusive():
            left = finish_deletions(self.storage)
            if left:
                _log_unremoved(left)
            self.storage.prepare()
            take_over(self.storage)
            self._open_audit()
            self.models.keep()
            try:
                self._readers.warm_up()
                self._workers.warm_up()
                self._notifier.start()
                interrupted, waiting = self._queue.recover()
                if waiting:
                    log.warning("after the restart: %d fits wait, %d of them had started", waiting, interrupted)
                self._sweep.start()
                yield self
            finally:
                self._sweep.stop()
                self._notifier.stop()
                self._queue.stop()
                self.pool.stop()
                self.audit.flush()
                self.storage.close()

    def _open_audit(self) -> None:
        self.audit.later(Entry("service", "service", "started"))
        self.audit.flush()
        with suppress(OSError):  # no room: the line waits
            log.info("the audit log ends with line %s; kept elsewhere, it is an anchor", self.audit.end())

    @property
    def workers(self) -> int:
        """The number of fits that can run at once."""
        return self._workers.workers

    def on_fit_end(self, notify: Callable[[str, float], None]) -> None:
        """`notify(state, seconds)` is called when a fit has ended, in any thread."""
        self._queue.notify_end = notify

    def end_streams(self) -> None:
        """Ends every open stream, so that the server's threads are free to go."""
        self._notifier.stop()

    def delete_scan(self, scan_id: str) -> None:
        """Removes the scan, its landmarks and its fits.  No such scan is no error.

        Raises NotRemoved when files are left; they are tried again from time to time.
        """
        self.proposals.drop(scan_id)
        self.ink.drop(scan_id)
        fits = fits_of_scan(self.storage, scan_id)
        self._queue.drop(fits)
        left = delete_scan(self.storage, scan_id)
        self._forget(scan_id, *fits)
        self._notifier.look_again()
        if left:
            _log_unremoved(left)
            raise NotRemoved(len(left))

    def put_length(self, scan_id: str, length: tuple[End, End, float] | None) -> None:
        """Gives the scan its true size, with None its file's, as `put_length` of the storage does and raises."""
        self.proposals.drop(scan_id)
        self.ink.drop(scan_id)
        put_length(self.storage, scan_id, length)
        self._forget(scan_id, *fits_of_scan(self.storage, scan_id))

    def _forget(self, *ids: str) -> None:
        """Drops what processes hold of a scan and its fits, and all that was made of any."""
        for each in ids:
            self.pool.drop(each)
        for made in (self.plans, self.line_checks, self.reports, self.visits):
            made.forget()

    def delete_patient(self, patient_id: str) -> None:
        """Removes all scans of the patient with all that was made of them.  No such patient is no error.

        Raises NotRemoved as `delete_scan`, when it has tried all.
        """
        try:
            scans = scans_of_patient(self.storage, patient_id)
        except NotFound:
            return
        left = 0
        for scan_id in scans:
            try:
                if scan_id in self.storage.case(patient_id).scan_ids():  # it has not been moved meanwhile
                    self.delete_scan(scan_id)
            except NotRemoved as error:
                left += error.places
            except NotFound:
                break  # the patient went with the last scan
        delete_empty_case(self.storage, patient_id)
        if left:
            raise NotRemoved(left)

    def add_fit(self, scan_id: str, asked: FitDocument, once: Once | None = None, client: str | None = None) -> str:
        """Puts a fit of the scan into the queue; its id.

        The same request `once` more gives the id of the first.  Raises NotFound when a scan is gone, BadInput when
        `once` has the key of another request, TooMany when so many fits of the `client` wait already.
        """
        if once is not None:
            made = made_before(self.storage, once)
            if made is not None:
                return made
        with self._waiting.place(client) as waits:
            made = self._add_fit(scan_id, asked, once)
            waits(made)
        self._queue.wake()
        return made

    def add_prediction(self, fit_id: str, stance: Stance, client: str | None = None) -> str:
        """Puts a prediction from a fit that is done into the queue; its id, that of the same one made before.

        Raises NotFound, Conflict when the fit is not done, BadInput when nothing can be predicted from it, TooMany.
        """
        case, scan_id = self.storage.case_of_fit(fit_id)
        asked = asked_prediction(case, fit_id, stance)
        self.models.check_predicts(fit_id)
        return self.add_fit(scan_id, asked, client=client)

    def _add_fit(self, scan_id: str, asked: FitDocument, once: Once | None) -> str:
        fit_id = new_id()
        place = fit_place(fit_id)
        try:
            self.storage.files.make(place)
            made = add_fit(self.storage, scan_id, fit_id, asked, once)
        except BaseException:
            self.storage.discard(place)
            raise
        if made != fit_id:
            self.storage.discard(place)
        return made

    def cancel_fit(self, fit_id: str) -> StoredFit:
        """Raises NotFound, or Conflict when the fit is done or failed."""
        return self._queue.cancel(fit_id)

    def follow(
        self,
        fit_id: str,
        after: int,
        heartbeat_s: float,
        gone: Callable[[], bool] | None = None,
    ) -> Iterator[Sequence[StreamItem]]:
        """The fit's events above `after`, as they come, those together that are known at once.

        Before the first, its place in the queue.  `gone` as `follow` says.
        """
        return follow(self._notifier, fit_id, after, heartbeat_s, gone)

    def transfer(
        self,
        from_fit: str,
        to_fit: str,
        drawing: dict[str, Any] | None,
        other_patient: bool,
        same_patient: bool = False,
    ) -> dict[str, Any]:
        """A drawing of one fit's scan, on the other's (breastrig/drawing@1), made in a process of its own.

        Whose drawing it is has been asked already.  NeedsYes where the two scans do not look like one patient's, unless
        `same_patient`, or a person has said of these scans that they are.  Raises a BreastRigError
        with a sentence, NotFound when a fit was deleted meanwhile.
        """
        both = from_fit, to_fit
        source, goal = (self.storage.files.folder(fit_place(one)) for one in both)
        with (
            explained("Carrying this drawing", TRANSFER_WALL_S, "give smaller scans", self.storage, both),
            self.models.of_fits(both) as model,
        ):
            scans = [get_fit(self.storage, each).scan for each in both]
            is_said = scans[1] in said_same(self.storage, scans[0])
            task = partial(
                carried_between,
                source,
                goal,
                drawing,
                model=model,
                other_patient=other_patient,
                one_patient=same_patient or is_said,
            )
            carried = self._others.result(task, (), TRANSFER_WALL_S)
        return carried | ({"doubts": []} if is_said else {})

    def propose_marks(self, from_fit: str, to_fit: str, same_patient: bool = False) -> dict[str, Any]:
        """Pairs of marks by the colours of two fits' scans, found in a process of its own; raises as `transfer`."""
        both = from_fit, to_fit
        with (
            explained("Finding marks", MARKS_WALL_S, "give smaller scans", self.storage, both),
            self.models.of_fits(both) as model,
        ):
            scans = [get_scan(self.storage, get_fit(self.storage, each).scan) for each in both]
            files = [
                ScanFile(
                    self.storage.files.folder(scan_place(scan.id)) / upload_name(scan.file_type),
                    scan.file_type,
                    scan.facts["unit"],
                    get_cuts(self.storage, scan.id),
                )
                for scan in scans
            ]
            folders = [self.storage.files.folder(fit_place(each)) for each in both]
            is_said = scans[1].id in said_same(self.storage, scans[0].id)
            marks = [get_landmarks(self.storage, scan.id).marks_mm for scan in scans]
            both_marks = marks[0], marks[1]
            job = MarksJob((folders[0], folders[1]), (files[0], files[1]), both_marks, model, same_patient or is_said)
            found: dict[str, Any] = self._others.result(propose_marks_on_files, (job,), MARKS_WALL_S)
        return found


def _log_unremoved(left: list[Unremoved]) -> None:
    reasons = ", ".join(sorted({one.reason for one in left}))
    log.error("%d folders of deleted scans cannot be removed (%s); `breastrig purge` lists them", len(left), reasons)
