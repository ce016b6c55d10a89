"""Replays the events of a fit from any number, then waits for more."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from breastrig.service.events.feeds import Notifier
from breastrig.storage.rows.events import StoredEvent
from breastrig.workflow.events import LAST_KINDS

GONE_EVERY_S = 0.5  # how soon a viewer who left is noticed


@dataclass(frozen=True)
class Heartbeat:
    """Nothing new, but the stream is alive."""


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

    Only the first step asks the database.
    """
    with notifier.listen(fit_id) as listener:
        feed = listener.feed
        quiet_since = time.monotonic()
        sent_position: int | None = None
        while not notifier.stopped:
            listener.reset()
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
