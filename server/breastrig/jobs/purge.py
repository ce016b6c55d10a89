"""Deleting scans while no server runs."""

from collections.abc import Iterable

from breastrig.core.errors import BadSettings
from breastrig.jobs.sweep import overdue
from breastrig.storage.files import fit_place, scan_place
from breastrig.storage.fits import fit_ids
from breastrig.storage.open_location import SQLITE_FILE
from breastrig.storage.scans import delete_scan, scan_ids
from breastrig.storage.storage import Storage


def purge(storage: Storage, older_than_days: float | None) -> int:
    """Deletes the scans that are older (None: all) with everything made of them; how many there were.

    Raises BadSettings when there is no such data folder or a server holds it.
    """
    if storage.location.database is None and not (storage.root / SQLITE_FILE).is_file():
        raise BadSettings(f"There is no BreastRig data folder at {storage.root}; name it with --data.")
    storage.root.mkdir(mode=0o700, parents=True, exist_ok=True)
    with storage.exclusive():
        storage.prepare()
        every = older_than_days is None
        chosen: Iterable[str] = scan_ids(storage) if every else overdue(storage, older_than_days or 0.0)
        scans = list(chosen)
        for scan_id in scans:
            fits = delete_scan(storage, scan_id)
            storage.remove(scan_place(scan_id), *map(fit_place, fits))
        storage.remove_strangers({*map(scan_place, scan_ids(storage)), *map(fit_place, fit_ids(storage))})
    return len(scans)
