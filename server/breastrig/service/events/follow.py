"""Replays the events of a fit from any number, then waits for more.

Workers are other processes: they only write rows.  One thread (the notifier) looks for new rows while anybody waits,
and wakes those whose fit has one; each then reads its own fit's new events.  So fifty viewers cost one question to
the database every 20 ms, not fifty, and an event of one fit does not wake the viewers of the others.
"""

import logging
import threading
import time
from collections.abc import Callable, Iterator, Sequence
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
    """The fit waits, so many are before it.  It is no event of the fit: it is not stored and has no number."""

    position: int  # 1: the next to run


StreamItem = StoredEvent | Queued | Heartbeat


class Listener:
    """One who waits for news of one fit; made by `Notifier.listen`."""

    def __init__(self) -> None:
        self.queues = True  # whether news of other fits concern it too: its place in the queue may have changed
        self._notified = threading.Event()

    def reset(self) -> None:
        """A notification from here on ends the next `wait`; to be called before looking at what is there."""
        self._notified.clear()

    def wait(self, timeout_s: float) -> None:
        """Returns when it was notified since `reset`, at the latest after `timeout_s`."""
        self._notified.wait(timeout_s)

    def notify(self) -> None:
        self._notified.set()


class Notifier:
    """Wakes the listeners of a fit for which any process has stored an event, and all when `notify_all` is called."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._condition = threading.Condition()
        self._listeners: dict[str, set[Listener]] = {}  # by fit
        self._position = 0
        self._stopped = False
        self._thread = threading.Thread(target=self._watch, name="breastrig-notifier", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread and every wait."""
        with self._condition:
            self._stopped = True
            self._condition.notify_all()
        self.notify_all()
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

    def notify_all(self) -> None:
        """For what has no event: a fit was deleted."""
        with self._condition:
            for listeners in self._listeners.values():
                for listener in listeners:
                    listener.notify()

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
                self._notify({one.fit for one in news}, any(one.moves_queue for one in news))
            time.sleep(LOOK_EVERY_S)

    def _notify(self, fit_ids: set[str], queue_moved: bool) -> None:
        with self._condition:
            for fit_id, listeners in self._listeners.items():
                for listener in listeners:
                    if fit_id in fit_ids or (queue_moved and listener.queues):
                        listener.notify()


def follow(
    storage: Storage,
    notifier: Notifier,
    fit_id: str,
    after: int,
    heartbeat_s: float,
    gone: Callable[[], bool] | None = None,
) -> Iterator[Sequence[StreamItem]]:
    """The events of a fit with a number above `after`, those together that are known at once; ends after the last kind.

    While the fit waits, its place in the queue, each time that it changes.

    Ends early when the fit is deleted, the notifier is stopped, or `gone()` says that nobody listens any more.
    """
    with notifier.listen(fit_id) as listener:
        quiet_since = time.monotonic()
        sent_position: int | None = None
        while not notifier.stopped:
            listener.reset()
            if events := events_after(storage, fit_id, after):
                yield events
                after = events[-1].number
                quiet_since = time.monotonic()
                if events[-1].kind in LAST_KINDS:
                    return
            try:
                listener.queues = get_fit(storage, fit_id).state == "queued"
            except NotFound:
                return
            position = queue_position(storage, fit_id) if listener.queues else None
            if position is not None and position != sent_position:
                yield [Queued(position)]
                sent_position = position
                quiet_since = time.monotonic()
            left = quiet_since + heartbeat_s - time.monotonic()
            if left <= 0:
                yield [Heartbeat()]
                quiet_since = time.monotonic()
            if notifier.stopped:
                return
            listener.wait(max(0.0, min(GONE_EVERY_S, heartbeat_s if left <= 0 else left)))
            if gone is not None and gone():
                return
