"""The events of each fit: the lines of its log, appended by the one who holds its claim."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from breastrig.cases import fits
from breastrig.cases.layout import LOG, fit_part
from breastrig.core.errors import NotFound
from breastrig.storage.storage import Storage


@dataclass(frozen=True)
class StoredEvent:
    number: int
    kind: str
    json: str  # one line

    @cached_property
    def utf8(self) -> bytes:
        """The line as it is sent, encoded once for all who follow the fit."""
        return self.json.encode()


def log_of(storage: Storage, fit_id: str) -> Path:
    """The file of the fit's events; one that is not there for a fit that is gone."""
    return storage.files.fit(fit_id) / LOG


def events_after(storage: Storage, fit_id: str, after: int, limit: int | None = None) -> list[StoredEvent]:
    """The events with a greater number, in order; the first `limit` of them."""
    try:
        case, scan_id = storage.case_of_fit(fit_id)
    except NotFound:
        return []
    lines = fits.events_after(case.path / fit_part(scan_id, fit_id), after)
    return [_event(number, line) for number, line in lines[:limit]]


def event_of_kind(storage: Storage, fit_id: str, kind: str, offset: int = 0) -> StoredEvent | None:
    """The first event of a kind, or the one so many after it: for instance an iteration."""
    found = [event for event in events_after(storage, fit_id, 0) if event.kind == kind]
    return found[offset] if 0 <= offset < len(found) else None


def _event(number: int, line: bytes) -> StoredEvent:
    text = line.decode()
    start = '{"kind":"'
    kind = text[len(start) : text.index('"', len(start))] if text.startswith(start) else json.loads(text)["kind"]
    return StoredEvent(number, kind, text)
