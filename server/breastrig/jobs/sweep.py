"""Scans are kept for a stated time only: a thread looks every hour for those that are older, and deletes them.

The time counts from the upload, not from the last use, so that a person can be told the day.
"""

import logging
import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

from breastrig.storage.scans import scans_before
from breastrig.storage.storage import Storage, iso_utc

KEEP_DAYS = 30
LOOK_EVERY_S = 3600.0  # a scan is deleted at most an hour late

log = logging.getLogger(__name__)


def overdue(storage: Storage, days: float) -> list[str]:
    """The scans that were uploaded more than so many days ago."""
    return scans_before(storage, iso_utc(datetime.now(UTC) - timedelta(days=days)))


class Sweep:
    """Deletes overdue scans from `start` to `stop`."""

    def __init__(self, storage: Storage, delete: Callable[[str], None], keep_days: float) -> None:
        self._storage = storage
        self._delete = delete
        self._keep_days = keep_days
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="breastrig-sweep", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        while True:
            try:
                found = overdue(self._storage, self._keep_days)
                for scan_id in found:
                    if self._over.is_set():
                        return
                    self._delete(scan_id)
                if found:
                    log.info("%d scans were deleted: older than %g days", len(found), self._keep_days)
            except Exception:
                log.exception("old scans cannot be deleted")
            if self._over.wait(LOOK_EVERY_S):
                return
