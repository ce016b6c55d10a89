"""Rows for tests of storage and service."""

from breastrig.storage.rows.fits import NewFit, add_fits
from breastrig.storage.storage import Storage


def add_waiting_fit(storage: Storage, scan_id: str, fit_id: str) -> None:
    """Puts a fit with one landmark into the queue."""
    new_fit = NewFit(scan=scan_id, landmarks_mm={"nipple_L": [1.0, 2.0, 3.0]})
    add_fits(storage, "2026-01-01T00:00:01.000Z", {fit_id: new_fit})


def add_waiting_pair(storage: Storage, scan_id: str, other_scan: str, fit_ids: tuple[str, str]) -> None:
    """Puts two stances to be fitted together into the queue; the first leads."""
    scans = (scan_id, other_scan)
    new_fits = {fit: NewFit(scan=scan, landmarks_mm={}) for fit, scan in zip(fit_ids, scans, strict=True)}
    add_fits(storage, "2026-01-01T00:00:01.000Z", new_fits)
