"""Feeds of the fits that somebody follows, read once for all who follow the same.

Workers are other processes: they only write logs. One thread (the notifier) looks for new lines while anybody listens,
reads those of a fit once into its feed, and wakes the fit's listeners, who find them in memory. So fifty viewers cost
the disk no more than one, and an event of one fit does not wake the viewers of the others. A feed is dropped when
nobody listens to it any more, or its fit is deleted.
"""

import logging
import os
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from breastrig.core.errors import NotFound
from breastrig.index.questions import queue_positions
from breastrig.storage.documents.events import StoredEvent, events_after, log_of
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.storage import Storage
from breastrig.use.steps.events import LAST_KINDS

LOOK_EVERY_S = 0.02  # an iteration takes about 20 ms: later would show two at once
DELETED_EVERY_S = 0.5  # how soon it is noticed that another server has deleted a fit

log = logging.getLogger(__name__)


class Listener(threading.Event):
    """One who waits for news of one fit, set when there are some; made by `Notifier.listen`."""

    def __init__(self, feed: "Feed") -> None:
        super().__init__()
        self.feed = feed


class Feed:
    """One fit as it was last read.  Whoever looks needs no lock: events are only added, the rest is replaced."""

    def __init__(self, storage: Storage, fit_id: str) -> None:
        self.events: list[StoredEvent] = []  # from the first, without gaps
        self.queue_position: int | None = None  # 1: the next to run; None when it does not wait
        self.is_deleted = False
        self.listeners: set[Listener] = set()  # the notifier's, under its lock
        self.is_read = False
        self.asked_again = False  # whether it is to be read although there is no event
        self.read_at = 0.0  # time.monotonic()
        self._storage = storage
        self._fit_id = fit_id
        self._lock = threading.Lock()
        self._log = log_of(storage, fit_id)
        self.log_size = 0

    def size(self) -> int:
        """Size of the fit's log, bytes; zero before the first event, and for a fit that is gone."""
        try:
            return os.stat(self._log).st_size
        except OSError:
            self._log = log_of(self._storage, self._fit_id)  # the scan may have become another patient's
            return 0

    def read(self) -> bool:
        """Takes in what is new; whether anything is.  Raises sqlite3.Error, then it has to be read again."""
        with self._lock:
            return self._read()

    def read_once(self) -> None:
        """For the first who listens; the others wait for it."""
        with self._lock:
            if not self.is_read:
                self._read()

    def _read(self) -> bool:
        before = (len(self.events), self.queue_position, self.is_deleted)
        self.log_size = self.size()
        self.asked_again, self.read_at = False, time.monotonic()
        try:
            self.events += events_after(self._storage, self._fit_id, len(self.events))
            get_fit(self._storage, self._fit_id)
            self.queue_position = self._storage.index.asked(queue_positions, [self._fit_id]).get(self._fit_id)
        except NotFound:
            self.is_deleted = True
        except sqlite3.Error:
            self.asked_again = True
            raise
        self.is_read = True
        return before != (len(self.events), self.queue_position, self.is_deleted)


class Notifier:
    """Keeps the feeds of all fits that are listened to, and wakes the listeners of those that have news."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._condition = threading.Condition()
        self._feeds: dict[str, Feed] = {}  # by fit
        self._changes = -1
        self._stopped = False
        self._thread = threading.Thread(target=self._watch, name="breastrig-notifier", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread and every wait."""
        with self._condition:
            self._stopped = True
            self._condition.notify_all()
            listeners = [listener for feed in self._feeds.values() for listener in feed.listeners]
        for listener in listeners:
            listener.set()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def stopped(self) -> bool:
        return self._stopped

    @property
    def listening(self) -> int:
        """The number of listeners."""
        with self._condition:
            return sum(len(feed.listeners) for feed in self._feeds.values())

    @contextmanager
    def listen(self, fit_id: str) -> Iterator[Listener]:
        """A listener for the fit's news, whose feed has been read."""
        with self._condition:
            feed = self._feeds.get(fit_id) or self._feeds.setdefault(fit_id, Feed(self._storage, fit_id))
            listener = Listener(feed)
            feed.listeners.add(listener)
            self._condition.notify_all()
        try:
            feed.read_once()  # after it is known to the notifier: what is stored from here on is news
            yield listener
        finally:
            with self._condition:
                feed.listeners.discard(listener)
                if not feed.listeners and self._feeds.get(fit_id) is feed:
                    del self._feeds[fit_id]

    def look_again(self) -> None:
        """Wakes listeners after a change without an event: a fit was deleted."""
        with self._condition:
            for feed in self._feeds.values():
                feed.asked_again = True

    def _watch(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._stopped or bool(self._feeds))
                if self._stopped:
                    return
            try:
                self._look()
            except sqlite3.Error:
                log.exception("the events cannot be read")
            time.sleep(LOOK_EVERY_S)

    def _look(self) -> None:
        changes = self._storage.index.changes
        queue_moved, self._changes = changes != self._changes, changes
        long_ago = time.monotonic() - DELETED_EVERY_S
        with self._condition:
            concerned = [
                feed
                for feed in self._feeds.values()
                if feed.size() != feed.log_size
                or feed.asked_again
                or feed.read_at <= long_ago
                or (queue_moved and feed.queue_position is not None)
            ]
        for feed in concerned:
            feed.asked_again = True  # until it is read: an error leaves it so
        for feed in concerned:
            if feed.read():
                with self._condition:
                    listeners = list(feed.listeners)
                for listener in listeners:
                    listener.set()


GONE_EVERY_S = 0.5  # how soon a viewer who left is noticed


@dataclass(frozen=True)
class Heartbeat:
    """A sign that the stream is alive, without news."""


@dataclass(frozen=True)
class Queued:
    """The fit waits, so many are before it.  It is no event of the fit: it is not stored and has no number."""

    position: int  # 1: the next to run


StreamItem = StoredEvent | Queued | Heartbeat


def follow(
    notifier: Notifier,
    fit_id: str,
    after: int,
    heartbeat_s: float,
    gone: Callable[[], bool] | None = None,
) -> Iterator[Sequence[StreamItem]]:
    """The events of a fit with a number above `after`, those together that are known at once; ends after the last kind.

    While the fit waits, its place in the queue, each time that it changes.

    Ends early when the fit is deleted, the notifier is stopped, or `gone()` says that nobody listens any more.

    Only the first step reads.
    """
    with notifier.listen(fit_id) as listener:
        feed = listener.feed
        quiet_since = time.monotonic()
        sent_position: int | None = None
        while not notifier.stopped:
            listener.clear()  # before looking: what comes from here on ends the wait
            if events := feed.events[after:]:
                yield events
                after = events[-1].number
                quiet_since = time.monotonic()
                if events[-1].kind in LAST_KINDS:
                    return
            if feed.is_deleted:
                return
            position = feed.queue_position
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
