"""The queue of fits, the oldest first: those that were requested and have not started. It keeps the workers busy.

A server that dies loses nothing: at the next start the fits that ran go back to their places in the queue, and go on
with their events. A fit whose own process died is not started again, because it would most likely die again: it fails
with a sentence.
"""

import logging
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import wait
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from breastrig.cases.fits import cancel_fit, end_abandoned
from breastrig.core.errors import BreastRigError, Conflict, NotFound, TooMany
from breastrig.core.model_choice import ModelChoice
from breastrig.execution.executor import Executor
from breastrig.execution.limits import FitLimits
from breastrig.fitting.prepare_scan import keeping
from breastrig.index.questions import count_by_state, next_waiting, note_state, put_back, queue_positions
from breastrig.service.failed_tasks import FULL
from breastrig.service.fits.fit_worker import UNWRITTEN, execute_fit
from breastrig.storage.documents.fits import StoredFit, get_fit
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import Runners
from breastrig.use.steps.events import Cancelled, Event, Failed, event_json

STARTS = 3  # a process may die before it has claimed its fit; then the fit is started again, so often at most
SETTLE_AGAIN_S = 1.0
LOOK_S = 1.0  # how soon a worker that has joined a cluster is given a waiting fit
KILL_S = 10.0  # a killed process is gone within milliseconds, unless its disk hangs
DIED = "The fit's process ended unexpectedly, perhaps for want of memory; start the fit again or give a smaller scan."
LOST = "The cluster's scheduler was lost while this fit ran; start the fit again."
SILENT = "The fit ended without a result; this is an error inside BreastRig."

log = logging.getLogger(__name__)


class FitQueue:
    """Starts, watches and stops fits.  All methods may be called from any thread."""

    def __init__(
        self,
        storage: Storage,
        processes: Executor,
        limits: FitLimits,
        runners: Runners,
        models: ModelChoice,
    ) -> None:
        self._storage = storage
        self._root = storage.root  # as the workers see it
        self._processes = processes
        self._limits = limits
        self._runners = runners
        self._models = models
        self._lock = threading.RLock()
        self._running: dict[str, Any] = {}  # fit id -> future
        self._starts: dict[str, int] = {}
        self._began: dict[str, float] = {}  # fit id -> time.monotonic() of its last start
        self.notify_end: Callable[[str, float], None] | None = None  # (state, seconds) of each fit that ends
        self._stopping = False
        self._stop_looking = threading.Event()
        self._look = threading.Thread(target=self._look_on, name="breastrig-queue", daemon=True)

    def recover(self) -> tuple[int, int]:
        """After a start: takes up the fits that ran, and those that waited.  (how many ran, how many wait now)."""
        with self._storage.index.writing() as rows:
            interrupted = put_back(rows)
        waiting = self._storage.index.asked(count_by_state).get("queued", 0)
        self.wake()
        self._look.start()
        return interrupted, waiting

    def wake(self) -> None:
        """Gives free workers the oldest waiting fits."""
        with self._lock:
            while not self._stopping and len(self._running) < self._processes.workers:
                found = self._storage.index.asked(next_waiting, set(self._running))
                if found is None:
                    break
                self._start(found[2])

    def cancel(self, fit_id: str) -> StoredFit:
        """Ends the fit and kills its process.

        Raises NotFound, or Conflict when it is done or failed.
        """
        asked = get_fit(self._storage, fit_id)
        if asked.ended and asked.state != "cancelled":
            raise Conflict(f"This fit has already ended: it is {asked.state}.")
        case, scan_id = self._storage.case_of_fit(fit_id)
        cancel_fit(case, scan_id, fit_id)  # from here on nothing is stored but its end
        self._kill(fit_id)
        self._storage.files.wait_until_free(fit_id, KILL_S)
        self._end(fit_id, Cancelled())
        self._storage.index.refresh(case.id)
        return get_fit(self._storage, fit_id)

    def drop(self, fit_ids: list[str]) -> None:
        """Ends fits that are about to be deleted, or already are, and waits until their processes are dead."""
        for fit_id in fit_ids:
            self._kill(fit_id)  # the deletion itself is its end
        for fit_id in fit_ids:
            if not self._storage.files.wait_until_free(fit_id, KILL_S):
                log.error("the process of fit %s does not end", fit_id)

    def stop(self) -> None:
        """Waits a little for running fits, then kills them; they go back into the table's queue."""
        with self._lock:
            self._stopping = True
            running = dict(self._running)
        self._stop_looking.set()
        wait(running.values(), timeout=self._limits.grace_s)
        self._processes.stop()
        try:
            with self._storage.index.writing() as rows:
                put_back(rows)
        except sqlite3.Error as unwritten:  # the next start does it
            log.error("the fits that ran cannot be put back yet: %s", type(unwritten).__name__)

    def _look_on(self) -> None:
        """Wakes the queue regularly, for workers that come and go; adding or ending a fit wakes it at once."""
        while not self._stop_looking.wait(LOOK_S):
            try:
                self.wake()
            except Exception:
                log.exception("the queue cannot be read")

    def _start(self, fit_id: str) -> None:
        self._starts[fit_id] = self._starts.get(fit_id, 0) + 1
        self._began[fit_id] = time.monotonic()
        with self._storage.index.writing() as rows:
            note_state(rows, fit_id, "running")
        task = (execute_fit, self._root, fit_id, self._runners, self._models)
        future = self._processes.schedule(keeping, task, self._limits.wall_s, self._scan_of(fit_id))
        self._running[fit_id] = future
        future.add_done_callback(lambda ended: self._on_end(fit_id, ended))

    def _on_end(self, fit_id: str, future: Any) -> None:
        """Handles a task's end; called in its thread, or in the one that cancelled."""
        try:
            with self._lock:
                self._running.pop(fit_id, None)
                seconds = time.monotonic() - self._began.pop(fit_id)
                if self._stopping:
                    return
            if not future.cancelled():
                self._surely(fit_id, partial(self._settle, fit_id, future.exception()))
            self._notify_end(fit_id, seconds)
            self.wake()
        except Exception:
            log.exception("after the end of fit %s", fit_id)

    def _notify_end(self, fit_id: str, seconds: float) -> None:
        if self.notify_end is not None:
            with suppress(NotFound):
                fit = get_fit(self._storage, fit_id)
                if fit.ended:
                    self.notify_end(fit.state, seconds)

    def _surely(self, fit_id: str, store: Callable[[], None]) -> None:
        """Retries until the end of the fit is stored, while the disk is full or the case is held."""
        try:
            store()
        except (sqlite3.Error, OSError, Conflict) as unwritten:
            log.error("the end of fit %s cannot be stored yet: %s", fit_id, type(unwritten).__name__)
            if not self._stopping:  # else the next start says it
                again = threading.Timer(SETTLE_AGAIN_S, self._surely, (fit_id, store))
                again.daemon = True
                again.start()

    def _settle(self, fit_id: str, error: BaseException | None) -> None:
        """Makes sure that the fit has an end."""
        with suppress(NotFound):  # deleted in the meantime
            fit = get_fit(self._storage, fit_id)
            if not fit.ended:
                if isinstance(error, TimeoutError):
                    reason = f"The fit took longer than {self._limits.wall_s:g} s and was stopped."
                    self._end(fit_id, Failed(reason=reason))
                elif fit.state == "queued" and self._starts[fit_id] < STARTS:
                    with self._storage.index.writing() as rows:
                        note_state(rows, fit_id, "queued")
                    return
                else:
                    log.error("fit %s ended without an end: %s", fit_id, type(error).__name__)
                    self._end(fit_id, Failed(reason=_why(error)))
        self._starts.pop(fit_id, None)
        with suppress(NotFound):
            self._storage.index.refresh(self._storage.case_of_fit(fit_id)[0].id)

    def _scan_of(self, fit_id: str) -> str | None:
        """The scan that the fit looks at; None for a prediction, and for a fit that was deleted meanwhile."""
        with suppress(NotFound):
            fit = get_fit(self._storage, fit_id)
            return fit.scan if fit.predicted_from is None else None
        return None

    def _end(self, fit_id: str, event: Event) -> None:
        with suppress(NotFound):
            case, scan_id = self._storage.case_of_fit(fit_id)
            end_abandoned(case, scan_id, fit_id, event_json(event))

    def _kill(self, fit_id: str) -> None:
        with self._lock:
            future = self._running.get(fit_id)
        if future is not None:
            future.cancel()
        else:
            self.wake()


def _why(error: BaseException | None) -> str:
    """The sentence for a fit whose process ended without storing an end."""
    if error is None:
        return SILENT
    if isinstance(error, BreastRigError):
        return str(error)
    if isinstance(error, ConnectionError):
        return LOST
    is_unwritten = isinstance(error, sqlite3.Error) or getattr(error, "errno", None) in FULL
    return UNWRITTEN if is_unwritten else DIED


RETRY_S = 2  # a fit takes about a second


class WaitingCap:
    """Counts each client's waiting fits."""

    def __init__(self, storage: Storage, most: int) -> None:
        self._storage = storage
        self._most = most
        self._lock = threading.Lock()
        self._asked: dict[str, set[str]] = {}  # client -> its fits, those that no longer wait are dropped at times

    @contextmanager
    def place(self, client: str | None) -> Iterator[Callable[[str], None]]:
        """A place for one more fit; to be called with the fit's id.  Raises TooMany when the client has no place left.

        None is a caller inside the program, which is not counted.
        """
        if client is None:
            yield lambda _fit_id: None
            return
        with self._lock:
            waiting = set(self._storage.index.asked(queue_positions, self._asked.get(client, set())))
            if len(waiting) >= self._most:
                raise TooMany(
                    f"{len(waiting)} of your fits are waiting already, as many as one client may have; "
                    f"ask again in {RETRY_S} s.",
                    RETRY_S,
                )
            self._asked[client] = waiting
            self._asked = {name: fits for name, fits in self._asked.items() if fits or name == client}
            yield waiting.add
