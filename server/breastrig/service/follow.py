"""Replays a story from any number, then waits for more.

Workers are other processes: they only write rows.  One thread (the bell) looks for new rows while anybody waits,
and wakes those whose fit has one; each then reads its own fit's new events.  So fifty viewers cost one question to
the database every 20 ms, not fifty, and an event of one fit does not wake the viewers of the others.
"""

import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import NotFound
from breastrig.storage.rows.events import StoredEvent, events_after, news_after
from breastrig.storage.rows.fits import get_fit, queue_position
from breastrig.storage.storage import Storage
from breastrig.workflow.events import LAST_KINDS

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


class Listener:
    """One who waits for news of one fit; made by `Bell.listen`."""

    def __init__(self) -> None:
        self.queues = True  # whether news of other fits concern it too: its place in the queue may have changed
        self._rung = threading.Event()

    def attend(self) -> None:
        """What rings from here on ends the next `wait`; to be called before looking at what is there."""
        self._rung.clear()

    def wait(self, timeout_s: float) -> None:
        """Returns when it has rung since `attend`, at the latest after `timeout_s`."""
        self._rung.wait(timeout_s)

    def ring(self) -> None:
        self._rung.set()


class Bell:
    """Rings for those whom an event concerns that any process stored, and for all when `ring` is called."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._condition = threading.Condition()
        self._listeners: dict[str, set[Listener]] = {}  # by fit
        self._position = 0
        self._stopped = False
        self._thread = threading.Thread(target=self._watch, name="breastrig-bell", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread and every wait."""
        with self._condition:
            self._stopped = True
            self._condition.notify_all()
        self.ring()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def stopped(self) -> bool:
        return self._stopped

    @property
    def listening(self) -> int:
        """How many listen."""
        with self._condition:
            return sum(map(len, self._listeners.values()))

    @contextmanager
    def listen(self, fit_id: str) -> Iterator[Listener]:
        """A listener for the fit's news."""
        listener = Listener()
        with self._condition:
            self._listeners.setdefault(fit_id, set()).add(listener)
            self._condition.notify_all()
        try:
            yield listener
        finally:
            with self._condition:
                left = self._listeners[fit_id]
                left.discard(listener)
                if not left:
                    del self._listeners[fit_id]

    def ring(self) -> None:
        """For what no event tells: a fit was deleted."""
        with self._condition:
            for listeners in self._listeners.values():
                for listener in listeners:
                    listener.ring()

    def _watch(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._stopped or bool(self._listeners))
                if self._stopped:
                    return
            try:
                news = news_after(self._storage, self._position)
            except SQLAlchemyError:
                log.exception("the events cannot be read")
                news = []
            if news:
                self._position = max(one.position for one in news)
                self._tell({one.fit for one in news}, any(one.moves_queue for one in news))
            time.sleep(LOOK_EVERY_S)

    def _tell(self, fit_ids: set[str], queue_moved: bool) -> None:
        with self._condition:
            for fit_id, listeners in self._listeners.items():
                for listener in listeners:
                    if fit_id in fit_ids or (queue_moved and listener.queues):
                        listener.ring()


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
    with bell.listen(fit_id) as listener:
        quiet_since = time.monotonic()
        told: int | None = None
        while not bell.stopped:
            listener.attend()
            for event in events_after(storage, fit_id, after):
                yield event
                after = event.number
                quiet_since = time.monotonic()
                if event.kind in LAST_KINDS:
                    return
            try:
                listener.queues = get_fit(storage, fit_id).state == "queued"
            except NotFound:
                return
            position = queue_position(storage, fit_id) if listener.queues else None
            if position is not None and position != told:
                yield Queued(position)
                told = position
                quiet_since = time.monotonic()
            left = quiet_since + heartbeat_s - time.monotonic()
            if left <= 0:
                yield Heartbeat()
                quiet_since = time.monotonic()
            if bell.stopped:
                return
            listener.wait(max(0.0, min(GONE_EVERY_S, heartbeat_s if left <= 0 else left)))
            if gone is not None and gone():
                return
