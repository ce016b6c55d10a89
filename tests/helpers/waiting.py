"""Waiting for other processes without sleeping longer than needed."""

import time
from collections.abc import Callable
from itertools import chain

from breastrig.cases.documents import FitDocument
from breastrig.service.service import Service
from breastrig.storage.documents.events import StoredEvent
from breastrig.storage.documents.fits import StoredFit, get_fit
from breastrig.storage.storage import utc_now

PATIENCE_S = 120.0  # a busy machine; nothing waits that long when all is well


def until(true: Callable[[], bool], what: str) -> None:
    """Returns soon after `true()` is; fails after PATIENCE_S.

    The longer it has waited the more rarely it looks: looking takes the time that the others need.
    """
    began = time.monotonic()
    while not true():
        waited = time.monotonic() - began
        assert waited < PATIENCE_S, f"waited in vain for: {what}"
        time.sleep(min(0.005 + 0.05 * waited, 0.05))


def ask_for_fit(service: Service, scan_id: str, preset: str = "default") -> str:
    return service.add_fit(scan_id, FitDocument(asked_at=utc_now(), preset=preset))


def ended(service: Service, fit_id: str) -> StoredFit:
    """The fit once it has ended."""
    until(lambda: get_fit(service.storage, fit_id).ended, f"the end of fit {fit_id}")
    return get_fit(service.storage, fit_id)


def stored_events(service: Service, fit_id: str, after: int = 0) -> list[StoredEvent]:
    """The whole stream to its end, without heartbeats."""
    news = chain.from_iterable(service.follow(fit_id, after, 5.0))
    return [event for event in news if isinstance(event, StoredEvent)]
