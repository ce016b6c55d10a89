"""Rows for tests of storage and service."""

from breastrig.storage.rows.fits import NewFit, add_fit
from breastrig.storage.storage import Storage


def add_waiting_fit(storage: Storage, scan_id: str, fit_id: str) -> None:
    """Puts a fit with one landmark into the queue."""
    new_fit = NewFit(scan=scan_id, landmarks_mm={"nipple_L": [1.0, 2.0, 3.0]})
    add_fit(storage, "2026-01-01T00:00:01.000Z", fit_id, new_fit)
