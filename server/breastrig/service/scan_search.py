"""Searches on a scan: computed once, in a process of its own, and kept with the scan's rows.

Whoever asks while it is being computed waits for the same computation.  A failure is raised for those who wait and is
not kept: the next call tries again.
"""

import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, wait
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from breastrig.core.errors import BreastRigError, FitFailed, NotFound
from breastrig.execution.executor import Executor
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.rows.scans import ScanRow, get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.tasks import keeping

Task = tuple[Callable[[Any], dict[str, Any]], Any]  # a function of a named module, and what it is given

log = logging.getLogger(__name__)


class ScanSearch(ABC):
    """The searches of one kind, on all scans.  All methods may be called from any thread.

    `variant` says with what it is searched, such as a model; one that has no variants has the empty one.
    """

    what: str  # "Finding landmarks"
    instead: str  # what a person can do when it breaks

    def __init__(self, storage: Storage, processes: Executor, wall_s: float) -> None:
        self._storage = storage
        self._processes = processes
        self._wall_s = wall_s
        self._lock = threading.Lock()
        self._running: dict[tuple[str, str], Any] = {}  # by scan and variant; a failed one stays until it was raised

    @abstractmethod
    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        """What was found and kept."""

    @abstractmethod
    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        """Keeps it.  Raises NotFound when the scan is gone."""

    @abstractmethod
    def _task(self, file: Path, scan: ScanRow) -> Task:
        """What is to be computed; `file` is the scan's."""

    def get(self, scan: ScanRow, variant: str, wait_s: float) -> dict[str, Any] | None:
        """What is found; None when it takes more than `wait_s` and goes on.

        Raises a BreastRigError when it cannot be done, NotFound when the scan was deleted meanwhile.
        """
        future = self._future(scan, variant)
        if not wait([future], timeout=wait_s).done:
            return None
        try:
            found: dict[str, Any] = future.result()
            return found
        except CancelledError as error:
            raise NotFound("This scan was deleted.") from error
        except Exception as error:
            self._forget((scan.id, variant), future)
            get_scan(self._storage, scan.id)
            raise self._as_sentence(error) from error

    def known(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        """What has been found, also while it is still being stored; None where nothing has."""
        with self._lock:
            ended = self._running.get((scan_id, variant))
        if ended is not None and ended.done() and not ended.cancelled() and ended.exception() is None:
            found: dict[str, Any] = ended.result()
            return found
        return self._stored(scan_id, variant)

    def drop(self, scan_id: str) -> None:
        """Stops what runs for a scan that is being deleted."""
        with self._lock:
            dropped = [self._running.pop(key) for key in list(self._running) if key[0] == scan_id]
        for future in dropped:
            future.cancel()

    def _future(self, scan: ScanRow, variant: str) -> Any:
        """Of the search that runs, else of what is stored, else of a search that is started.

        A search leaves `_running` once it is stored, so that looking there first misses none.
        """
        key = scan.id, variant
        with self._lock:
            future = self._running.get(key)
            if future is not None:
                return future
            stored = self._stored(scan.id, variant)
            if stored is not None:
                future = Future()
                future.set_result(stored)
                return future
            fetched = ExitStack()
            name = upload_name(scan.file_type)
            try:
                folder = fetched.enter_context(self._storage.files.reading(scan_place(scan.id), [name]))
                function, given = self._task(folder / name, scan)
                future = self._processes.schedule(keeping, (function, given), self._wall_s, scan.id)
            except BaseException:
                fetched.close()
                raise
            self._running[key] = future
        future.add_done_callback(lambda _ended: fetched.close())
        future.add_done_callback(lambda ended: self._keep(scan.id, variant, ended))
        return future

    def _keep(self, scan_id: str, variant: str, future: Any) -> None:
        """In the task's thread: stores what was found, even when nobody waits any more."""
        if future.cancelled() or future.exception() is not None:
            return
        try:
            with suppress(NotFound):  # the scan was deleted meanwhile
                self._store(scan_id, variant, future.result())
        except Exception:
            log.exception("what was found on a scan cannot be stored")
        self._forget((scan_id, variant), future)

    def _forget(self, key: tuple[str, str], future: Any) -> None:
        with self._lock:
            if self._running.get(key) is future:
                del self._running[key]

    def _as_sentence(self, error: Exception) -> BreastRigError:
        if isinstance(error, BreastRigError):
            return error
        if isinstance(error, TimeoutError):
            return FitFailed(f"{self.what} took longer than {self._wall_s:g} s; simplify the scan first.")
        log.error("the process that looked on a scan broke: %r", error)
        return FitFailed(f"{self.what} on this scan broke; the server's log says why. {self.instead}")
