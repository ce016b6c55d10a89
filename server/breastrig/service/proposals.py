"""Proposed landmarks: computed once a scan, in a process of its own, kept with the scan's rows.

Whoever asks while they are being computed waits for the same computation.  A failure is raised for those who wait
and is not kept: the next call tries again.
"""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, wait
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from breastrig.core.errors import BreastRigError, FitFailed, NotFound
from breastrig.execution.executor import Executor
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.rows.proposals import get_proposals, put_proposals
from breastrig.storage.rows.scans import ScanRow, get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.propose_on_scan import ProposeJob

Proposer = Callable[[ProposeJob], dict[str, Any]]

log = logging.getLogger(__name__)


class Proposals:
    """The proposals of all scans.  All methods may be called from any thread."""

    def __init__(
        self, storage: Storage, processes: Executor, wall_s: float, proposer: Proposer, model: Path | None
    ) -> None:
        self._storage = storage
        self._processes = processes
        self._wall_s = wall_s
        self._proposer = proposer
        self._model = model
        self._lock = threading.Lock()
        self._running: dict[tuple[str, str], Any] = {}  # by scan and model; a failed one stays until it was raised

    def get(self, scan: ScanRow, model_sha256: str, wait_s: float) -> dict[str, Any] | None:
        """{name: {point (mm), confidence, on_scan, error_mm}}; None when it takes more than `wait_s` and goes on.

        Raises a BreastRigError when it cannot be done, NotFound when the scan was deleted meanwhile.
        """
        stored = get_proposals(self._storage, scan.id, model_sha256)
        if stored is not None:
            return stored
        future = self._future(scan, model_sha256)
        if not wait([future], timeout=wait_s).done:
            return None
        try:
            found: dict[str, Any] = future.result()
            return found
        except CancelledError as error:
            raise NotFound("This scan was deleted.") from error
        except Exception as error:
            self._forget((scan.id, model_sha256), future)
            get_scan(self._storage, scan.id)
            raise self._as_sentence(error) from error

    def drop(self, scan_id: str) -> None:
        """Stops what runs for a scan that is being deleted."""
        with self._lock:
            dropped = [self._running.pop(key) for key in list(self._running) if key[0] == scan_id]
        for future in dropped:
            future.cancel()

    def _future(self, scan: ScanRow, model_sha256: str) -> Any:
        key = scan.id, model_sha256
        with self._lock:
            future = self._running.get(key)
            if future is not None:
                return future
            fetched = ExitStack()
            name = upload_name(scan.file_type)
            try:
                folder = fetched.enter_context(self._storage.files.reading(scan_place(scan.id), [name]))
                job = ProposeJob(
                    folder / name, scan.file_type, scan.facts["unit"], self._model, scan.facts.get("orientation")
                )
                future = self._processes.schedule(self._proposer, (job,), timeout=self._wall_s)
            except BaseException:
                fetched.close()
                raise
            self._running[key] = future
        future.add_done_callback(lambda _ended: fetched.close())
        future.add_done_callback(lambda ended: self._keep(scan.id, model_sha256, ended))
        return future

    def _keep(self, scan_id: str, model_sha256: str, future: Any) -> None:
        """In Pebble's thread: stores what was found, even when nobody waits any more."""
        if future.cancelled() or future.exception() is not None:
            return
        try:
            with suppress(NotFound):  # the scan was deleted meanwhile
                put_proposals(self._storage, scan_id, model_sha256, future.result())
        except Exception:
            log.exception("the proposed landmarks of a scan cannot be stored")
        self._forget((scan_id, model_sha256), future)

    def _forget(self, key: tuple[str, str], future: Any) -> None:
        with self._lock:
            if self._running.get(key) is future:
                del self._running[key]

    def _as_sentence(self, error: Exception) -> BreastRigError:
        if isinstance(error, BreastRigError):
            return error
        if isinstance(error, TimeoutError):
            return FitFailed(f"Finding landmarks took longer than {self._wall_s:g} s; simplify the scan first.")
        log.error("the process that looked for landmarks broke: %r", error)
        return FitFailed("Finding landmarks on this scan broke; the server's log says why. Place them by hand.")
