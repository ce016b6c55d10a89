"""Fits for tests of storage and service."""

from typing import Any

from breastrig.cases.documents import FitDocument
from breastrig.cases.fits import claimed
from breastrig.storage.documents.fits import add_fit
from breastrig.storage.storage import Storage


def named(name: str) -> str:
    """An id that can be read."""
    return name.ljust(22, "-")


def add_waiting_fit(storage: Storage, scan_id: str, fit_id: str) -> None:
    """Puts a fit with one landmark into the queue."""
    add_fit(
        storage,
        scan_id,
        fit_id,
        FitDocument(asked_at="2026-01-01T00:00:01.000Z", landmarks_mm={"nipple_L": [1.0, 2.0, 3.0]}),
    )


def append(storage: Storage, fit_id: str, *events: dict[str, Any]) -> None:
    """One attempt at the fit, which tells these events after those that are stored already."""
    case, scan_id = storage.case_of_fit(fit_id)
    with claimed(case, scan_id, fit_id) as claim:
        assert claim is not None
        claim._counted = claim.stored  # what comes is new
        for event in events:
            claim.append(event)
    storage.index.refresh(case.id)


def scan_ids(storage: Storage) -> set[str]:
    """All scans that the index has."""
    return storage.index.asked(lambda rows: {row[0] for row in rows.execute("SELECT id FROM scans")})


def fit_ids(storage: Storage) -> set[str]:
    """All fits that the index has."""
    return storage.index.asked(lambda rows: {row[0] for row in rows.execute("SELECT id FROM fits")})
