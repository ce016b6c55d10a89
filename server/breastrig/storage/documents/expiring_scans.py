"""Scans that are nearly too old, with the time when their deletion was announced."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass

from breastrig.cases import layout
from breastrig.cases.documents import ExpiresDocument, content_of
from breastrig.cases.writing import put
from breastrig.core.errors import NotFound
from breastrig.index import questions
from breastrig.storage.storage import Storage


@dataclass(frozen=True)
class AgedScan:
    """Times as `iso_utc`."""

    id: str
    created_at: str
    announced_at: str | None


def aged_scans(storage: Storage, created_until: str) -> list[AgedScan]:
    """Scans of up to that time, and all whose deletion has been announced; the oldest first."""
    found = storage.index.asked(lambda rows: questions.aged_scans(rows, created_until))
    return [AgedScan(*row) for row in found]


def announce(storage: Storage, scan_ids: Iterable[str], now: str) -> None:
    """Notes that the scans' deletion is announced now, whatever was noted before.  One that is gone is left out."""
    for scan_id in scan_ids:
        with suppress(NotFound):
            case = storage.case_of_scan(scan_id)
            with case.writing():
                case.check_scan(scan_id)
                name = f"{layout.scan_part(scan_id)}/{layout.EXPIRES}"
                put(case.path, name, content_of(ExpiresDocument(announced_at=now)))
            storage.index.refresh(case.id)


def withdraw(storage: Storage, scan_ids: Iterable[str]) -> None:
    """Withdraws the announcement: the scans are not as old as it seemed."""
    for scan_id in scan_ids:
        with suppress(NotFound):
            case = storage.case_of_scan(scan_id)
            with case.writing():
                (case.scan_folder(scan_id) / layout.EXPIRES).unlink(missing_ok=True)
            storage.index.refresh(case.id)
