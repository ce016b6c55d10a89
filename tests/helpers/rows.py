"""Rows for tests of storage and jobs."""

from breastrig.storage.fits import add_fit
from breastrig.storage.storage import Storage


def add_waiting_fit(storage: Storage, scan_id: str, fit_id: str) -> None:
    """Puts a fit with one landmark into the queue."""
    add_fit(
        storage,
        fit_id=fit_id,
        scan_id=scan_id,
        created_at="2026-01-01T00:00:01.000Z",
        stance="auto",
        preset="default",
        drawing=None,
        landmarks_mm={"nipple_L": [1.0, 2.0, 3.0]},
    )
