"""Plans are stored with what is there at that moment."""

import hashlib

import pytest

from breastrig.core.errors import Conflict
from breastrig.storage.deletion import delete_scan
from breastrig.storage.rows.patients import get_plan, move_scan, patient_of_scan, put_plan
from breastrig.storage.rows.scans import ScanRow, add_scan
from breastrig.storage.storage import Storage


def item(scan: str) -> dict[str, str]:
    return {"id": f"on-{scan}", "kind": "note", "scan": scan, "text": "x"}


def add(storage: Storage, scan: str, patient: str | None = None) -> str:
    """The patient that the scan is of."""
    storage.files.make(f"scans/{scan}")
    facts = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}
    add_scan(
        storage,
        ScanRow(scan, "2026-01-01T00:00:01.000Z", "ply", hashlib.sha256(scan.encode()).hexdigest(), facts),
        patient,
    )
    return patient_of_scan(storage, scan)


def test_an_item_of_a_scan_that_went_meanwhile_is_not_stored(storage: Storage, scan_id: str) -> None:
    """The version is what it was, for nothing was planned on that scan: only the transaction can know."""
    patient = patient_of_scan(storage, scan_id)
    assert add(storage, "deleted", patient) == patient
    assert add(storage, "moved", patient) == patient
    stranger = add(storage, "strangers")
    assert put_plan(storage, patient, [item(scan_id)], 0) is not None
    delete_scan(storage, "deleted")
    move_scan(storage, "moved", stranger)
    for gone in ("deleted", "moved", "strangers"):
        with pytest.raises(Conflict, match=f'The scan of the item "on-{gone}" was deleted or moved meanwhile'):
            put_plan(storage, patient, [item(scan_id), item(gone)], 1)
    assert get_plan(storage, patient).items == (item(scan_id),)
    assert put_plan(storage, patient, [item(scan_id)], 1) is not None
