"""Finished fits that follow landmarks while somebody drags them: each in a warm process of its own, and few of those.

A process has one fit and no other, so that nothing of one patient is left for the next.  It ends when the scan is
deleted, when it was not asked for a while, when another fit needs its place, or with the server.  Nothing is stored:
what comes of a drag is a fit like any other, which is asked for when it has ended.
"""

import json
import logging
import threading
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from breastrig.core.errors import BreastRigError, Conflict, FitFailed, TooMany
from breastrig.execution.limits import FitLimits
from breastrig.execution.warm_process import WarmProcess
from breastrig.service.fit_worker import earlier_fit, fit_job
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.rows.events import events_of_kind
from breastrig.storage.rows.fits import FitRow, get_fit
from breastrig.storage.rows.scans import Points, get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.moved_landmarks import FollowJob, follow_landmarks

OPEN_S = 60.0  # reading and indexing a scan takes half a second, a huge one on a slow machine many
ANSWER_S = 10.0  # two iterations take a fortieth of a second
IDLE_S = 60.0  # who drags a landmark, looks, and drags again should not wait
RETRY_S = 2

log = logging.getLogger(__name__)


class _Followed:
    """A fit and its process; `lock` is held while somebody waits for it."""

    def __init__(self, fit: FitRow) -> None:
        self.fit = fit
        self.lock = threading.Lock()
        self.process: WarmProcess | None = None
        self.is_over = False
        self.used_at = time.monotonic()

    def end(self) -> None:
        self.is_over = True
        if self.process is not None:
            self.process.end()


class MovedLandmarks:
    """The fits that are at hand.  May be called from any thread."""

    def __init__(self, storage: Storage, limits: FitLimits, model: Path | None) -> None:
        self._storage = storage
        self._limits = limits
        self._model = model
        self._lock = threading.Lock()
        self._followed: dict[str, _Followed] = {}
        self._stopped = False
        self._timer: threading.Timer | None = None

    def moved(self, fit_id: str, landmarks: Points) -> bytes:
        """Where the model of a fit lies with landmarks (mm, scan frame) that were moved: JSON, see the workflow.

        Raises Conflict when the fit is not done, TooMany when all processes are at work for others, NotFound when it
        was deleted, FitFailed with a sentence.
        """
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; landmarks can be moved live on fits that are done.")
        followed = self._place(fit)
        try:
            with followed.lock:
                process = self._opened(followed)
                return process.answer(json.dumps({"landmarks": landmarks}).encode(), ANSWER_S)
        except BreastRigError:
            if not self._is_alive(followed):
                self._forget(followed)
            raise
        except OSError as error:  # TimeoutError is one
            self._forget(followed)
            get_fit(self._storage, fit_id)
            log.warning("the process that followed landmarks died: %r", error)
            raise FitFailed("The model could not follow the landmark; let go of it, and it is fitted anew.") from error
        finally:
            self._look_again_later()

    def drop(self, fit_ids: list[str]) -> None:
        """Ends what is at hand of these fits: they are deleted."""
        with self._lock:
            gone = [self._followed.pop(fit_id) for fit_id in fit_ids if fit_id in self._followed]
        for each in gone:
            each.end()

    def stop(self) -> None:
        with self._lock:
            self._stopped = True
            if self._timer is not None:
                self._timer.cancel()
        self.drop(list(self._followed))

    @property
    def count(self) -> int:
        """How many fits are at hand."""
        return len(self._followed)

    def _place(self, fit: FitRow) -> _Followed:
        with self._lock:
            if self._stopped:
                raise FitFailed("The service is stopping; ask again when it runs.")
            known = self._followed.get(fit.id)
            if known is not None and not known.is_over:
                known.used_at = time.monotonic()
                return known
            given_up = None
            if len(self._followed) >= self._limits.followed:
                given_up = self._longest_unused()
                if given_up is None:
                    raise TooMany(
                        f"{self._limits.followed} fits are being moved by hand, as many as there may be; ask again in "
                        f"{RETRY_S} s.",
                        RETRY_S,
                    )
                del self._followed[given_up.fit.id]
            made = self._followed[fit.id] = _Followed(fit)
        if given_up is not None:
            given_up.end()
        return made

    def _longest_unused(self) -> _Followed | None:
        """Of those that nobody waits for."""
        free = [each for each in self._followed.values() if not each.lock.locked()]
        return min(free, key=lambda each: each.used_at, default=None)

    def _opened(self, followed: _Followed) -> WarmProcess:
        if followed.is_over:
            raise FileNotFoundError("given up meanwhile")
        if followed.process is None:
            fit = followed.fit
            scan = get_scan(self._storage, fit.scan)
            with self._storage.files.reading(scan_place(scan.id), [upload_name(scan.file_type)]) as folder:
                job = fit_job(scan, fit, folder, folder, self._model)
                job = replace(job, stance=fit.stance, drawing=None, earlier=earlier_fit(self._storage, fit.id))
                followed.process = WarmProcess(
                    follow_landmarks, (FollowJob(job, self._not_followed(fit)),), self._limits.memory_bytes
                )
                followed.process.opened(OPEN_S)
            get_fit(self._storage, fit.id)  # one that was deleted meanwhile is not kept at hand
        return followed.process

    def _not_followed(self, fit: FitRow) -> tuple[str, ...]:
        (done,) = events_of_kind(self._storage, fit.id, "done")
        doubted = json.loads(done.json)["result"].get("landmarks_not_followed", [])
        return tuple(name for each in doubted for name in each["names"])

    def _is_alive(self, followed: _Followed) -> bool:
        return followed.process is not None and followed.process.is_alive

    def _forget(self, followed: _Followed) -> None:
        with self._lock:
            if self._followed.get(followed.fit.id) is followed:
                del self._followed[followed.fit.id]
        followed.end()

    def _look_again_later(self) -> None:
        with self._lock:
            if self._stopped or not self._followed or self._timer is not None:
                return
            self._timer = threading.Timer(IDLE_S / 4, self._end_unused)
            self._timer.daemon = True
            self._timer.start()

    def _end_unused(self) -> None:
        before = time.monotonic() - IDLE_S
        with self._lock:
            self._timer = None
            unused = [each for each in self._followed.values() if each.used_at < before and not each.lock.locked()]
            for each in unused:
                del self._followed[each.fit.id]
        for each in unused:
            with suppress(OSError):
                each.end()
        self._look_again_later()
