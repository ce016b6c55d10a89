"""Announcements that scans will be deleted by their age."""

from collections.abc import Iterable
from contextlib import suppress

from breastrig.cases import layout
from breastrig.cases.documents import ExpiresDocument, content_of
from breastrig.cases.writing import put
from breastrig.core.errors import NotFound
from breastrig.storage.storage import Storage


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
