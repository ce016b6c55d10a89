"""Scans are kept for a stated time only: a thread looks every hour for those that are older, and deletes them.

The same thread looks for what other programs have written into the cases.

The time counts from the upload, not from the last use, so that the day can be stated beforehand.

A clock can be wrong, and then every scan looks too old at once.  So a deletion is announced in the log a day before,
and done only if that day has really passed: by the server's uptime, or by the clock when another server has
announced it.  Announcements that turn out to be wrong, because the clock was set right, are withdrawn.
"""

import logging
import sqlite3
import threading
from collections.abc import Callable
from datetime import datetime, timedelta

from breastrig.audit.deletions import deletion
from breastrig.audit.log import AuditLog
from breastrig.core import wall_clock
from breastrig.core.errors import NotFound, NotRemoved
from breastrig.index.questions import AgedScan, aged_scans
from breastrig.storage.deletion import look, remove_left
from breastrig.storage.documents.expiring_scans import announce, withdraw
from breastrig.storage.storage import Storage, iso_utc

KEEP_DAYS = 30
LOOK_EVERY_S = 3600.0  # a scan is deleted at most an hour late
RETRY_EVERY_S = 60.0  # files that could not be removed
NEWS_EVERY_S = 2.0  # how soon it is seen what other programs have written
NEWS_SHARE = 50  # so many times as long it rests as it looked, where that is longer
GRACE = timedelta(days=1)  # time enough to see that the clock is wrong
AHEAD = timedelta(seconds=2 * LOOK_EVERY_S)  # so that a deletion which is announced in time is not late

log = logging.getLogger(__name__)


class Retention:
    """Decides which scans have been kept long enough; one for the life of a server."""

    def __init__(self, storage: Storage, keep_days: float) -> None:
        self._storage = storage
        self._keep = timedelta(days=keep_days)
        self._grace = min(GRACE, self._keep / 2)
        self._announce_at = self._keep - min(self._grace + AHEAD, self._keep)  # a scan's age then
        self._announced_here: dict[str, float] = {}  # scan -> uptime when this server announced its deletion
        self._said: datetime | None = None

    def due(self) -> list[str]:
        """The scans to be deleted now.  Announces the deletion of others."""
        now = wall_clock.now()
        found = self._storage.index.asked(aged_scans, iso_utc(now - self._announce_at))
        new = [scan.id for scan in found if self._is_new(scan, now)]
        wrong = [scan.id for scan in found if self._is_wrong(scan, now)]
        if new:
            announce(self._storage, new, iso_utc(now))
            self._announced_here.update(dict.fromkeys(new, wall_clock.uptime_s()))
        if wrong:
            withdraw(self._storage, wrong)
            log.warning("%d scans are not as old as the clock said before; they are kept", len(wrong))
        waiting = {scan.id: scan for scan in found if scan.id not in wrong}
        due = [scan.id for scan in waiting.values() if scan.id not in new and self._is_due(scan, now)]
        self._announced_here = {key: value for key, value in self._announced_here.items() if key in waiting}
        self._say([scan for scan in waiting.values() if scan.id not in due], new, now)
        return due

    def _is_old(self, scan: AgedScan, now: datetime) -> bool:
        """Whether its deletion has to have been announced."""
        return _moment(scan.created_at) + self._announce_at <= now

    def _is_new(self, scan: AgedScan, now: datetime) -> bool:
        """Whether it has to be announced: for the first time, or after an announcement by a clock that was ahead."""
        return self._is_old(scan, now) and (scan.announced_at is None or _moment(scan.announced_at) > now)

    def _is_wrong(self, scan: AgedScan, now: datetime) -> bool:
        """Whether its announcement came too early.  A clock that is behind even the upload cannot say that."""
        return scan.announced_at is not None and _moment(scan.created_at) <= now and not self._is_old(scan, now)

    def _is_due(self, scan: AgedScan, now: datetime) -> bool:
        if scan.announced_at is None or now < self._last_day(scan, scan.announced_at):
            return False
        here = self._announced_here.get(scan.id)
        return here is None or wall_clock.uptime_s() - here >= self._grace.total_seconds()

    def _last_day(self, scan: AgedScan, announced_at: str) -> datetime:
        return max(_moment(scan.created_at) + self._keep, _moment(announced_at) + self._grace)

    def _say(self, waiting: list[AgedScan], new: list[str], now: datetime) -> None:
        """Logs the announcement, at the server's start and whenever more are announced."""
        if waiting and (new or self._said is None):
            announced = {scan.id: iso_utc(now) if scan.id in new else str(scan.announced_at) for scan in waiting}
            log.warning(
                "%d scans are older than %g days or soon will be; if the clock is right, they are deleted from %s on",
                len(waiting),
                self._keep.total_seconds() / 86400,
                iso_utc(min(self._last_day(scan, announced[scan.id]) for scan in waiting)),
            )
        self._said = now


class Sweep:
    """Deletes scans and links that are too old, and files that could not be removed before, from `start` to `stop`."""

    def __init__(
        self,
        storage: Storage,
        delete: Callable[[str], None],
        keep_days: float | None,
        end_expired: Callable[[], None] = lambda: None,
        audit: AuditLog | None = None,
    ) -> None:
        self._storage = storage
        self._delete = delete
        self._end_expired = end_expired  # what links showed that are over
        self._audit = audit or AuditLog(storage.root)
        self._retention = None if keep_days is None else Retention(storage, keep_days)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="breastrig-sweep", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        looked_at = tried_at = -LOOK_EVERY_S
        while True:
            began = wall_clock.uptime_s()
            pause = NEWS_EVERY_S
            try:
                look(self._storage)
                self._audit.flush()
                pause = max(pause, NEWS_SHARE * (wall_clock.uptime_s() - began))
                if began - tried_at >= RETRY_EVERY_S:
                    tried_at = began
                    remove_left(self._storage)
                    self._storage.forget_pending()
                    self._storage.index.keep_room()
                    self._end_expired()
                if began - looked_at >= LOOK_EVERY_S:
                    looked_at = began
                    self._storage.index.check()
                    self._delete_old()
            except sqlite3.Error as error:  # the index is busy, which others say
                log.error("old scans cannot be looked for: %s", type(error).__name__)
            except Exception:
                log.exception("old scans cannot be deleted")
            if self._over.wait(pause):
                return

    def _delete_old(self) -> None:
        if self._retention is None:
            return
        found = self._retention.due()
        for scan_id in found:
            if self._over.is_set():
                return
            try:
                with deletion(self._audit, "service", "too old", self._storage.case_of_scan(scan_id).path, scan_id):
                    self._delete(scan_id)
            except NotFound:
                continue
            except NotRemoved as left:
                log.error("%d folders of a scan that was too old cannot be removed yet", left.places)
        if found:
            log.info("%d scans were deleted: they were too old", len(found))


def _moment(text: str) -> datetime:
    return datetime.fromisoformat(text)
