"""Replays a story from any number, then waits for more.

Workers are other processes: they only write rows.  One thread (the bell) looks whether any row came while
anybody waits, and wakes all that wait; each then reads its own fit's new events.  So fifty viewers cost one
question to the database every 20 ms, not fifty.
"""

import logging
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import NotFound
from breastrig.jobs.events import LAST_KINDS
from breastrig.storage.events import StoredEvent, events_after, last_position
from breastrig.storage.fits import get_fit, queue_position
from breastrig.storage.storage import Storage

LOOK_EVERY_S = 0.02  # an iteration takes about 20 ms: later would show two at once
GONE_EVERY_S = 0.5  # how soon a viewer who left is noticed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Heartbeat:
    """Nothing new, but the stream is alive."""


@dataclass(frozen=True)
class Queued:
    """The fit waits, so many are before it.  Not part of the story: it is not stored and has no number."""

    position: int  # 1: the next to run


class Bell:
    """Rings when an event was stored by any process, or when `ring` is called."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._condition = threading.Condition()
        self._position = 0
        self._rings = 0
        self._waiting = 0
        self._stopped = False
        self._thread = threading.Thread(target=self._watch, name="breastrig-bell", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread and every wait."""
        with self._condition:
            self._stopped = True
            self._condition.notify_all()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def stopped(self) -> bool:
        return self._stopped

    def heard(self) -> tuple[int, int]:
        """What has rung so far, to be given to `wait`."""
        with self._condition:
            return self._position, self._rings

    def wait(self, heard: tuple[int, int], timeout_s: float) -> None:
        """Returns when something rang after `heard`, at the latest after `timeout_s`, at once when stopped."""
        with self._condition:
            self._waiting += 1
            self._condition.notify_all()
            try:
                self._condition.wait_for(
                    lambda: self._stopped or (self._position, self._rings) != heard, timeout=timeout_s
                )
            finally:
                self._waiting -= 1

    def ring(self) -> None:
        """For what no event tells: a fit was deleted."""
        with self._condition:
            self._rings += 1
            self._condition.notify_all()

    def _watch(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._stopped or self._waiting > 0)
                if self._stopped:
                    return
            try:
                position = last_position(self._storage)
            except SQLAlchemyError:
                log.exception("the events cannot be read")
                position = self._position
            with self._condition:
                if position != self._position:
                    self._position = position
                    self._condition.notify_all()
            time.sleep(LOOK_EVERY_S)


def follow(
    storage: Storage,
    bell: Bell,
    fit_id: str,
    after: int,
    heartbeat_s: float,
    gone: Callable[[], bool] | None = None,
) -> Iterator[StoredEvent | Queued | Heartbeat]:
    """The events of a fit with a number above `after`; ends after the last kind.

    While the fit waits, its place in the queue, each time that it changes.

    Ends early when the fit is deleted, the bell is stopped, or `gone()` says that nobody listens any more.
    """
    quiet_since = time.monotonic()
    told: int | None = None
    while not bell.stopped:
        heard = bell.heard()
        for event in events_after(storage, fit_id, after):
            yield event
            after = event.number
            quiet_since = time.monotonic()
            if event.kind in LAST_KINDS:
                return
        try:
            waits = get_fit(storage, fit_id).state == "queued"
        except NotFound:
            return
        position = queue_position(storage, fit_id) if waits else None
        if position is not None and position != told:
            yield Queued(position)
            told = position
            quiet_since = time.monotonic()
        left = quiet_since + heartbeat_s - time.monotonic()
        if left <= 0:
            yield Heartbeat()
            quiet_since = time.monotonic()
        bell.wait(heard, max(0.0, min(GONE_EVERY_S, heartbeat_s if left <= 0 else left)))
        if gone is not None and gone():
            return
