"""Deleting a scan: its rows, those of its fits and links first, so that nobody can read them, then the files.

Whatever is interrupted or fails is in the journal of files, and is finished at the next start or attempt.  A full
disk is no obstacle: what has to be written goes into the reserve, and rows that are too many for it are deleted in
steps, once the files have made room.
"""

import logging
from functools import partial

from sqlalchemy import Connection, delete, select
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from breastrig.storage import schema
from breastrig.storage.file_journal import cancel_creations, clear_entries, pending_removals, record_removal
from breastrig.storage.files import fit_place, scan_place
from breastrig.storage.rows.fits import fit_ids, fits_of_scan
from breastrig.storage.rows.patients import forget_scan
from breastrig.storage.rows.queries import is_there
from breastrig.storage.rows.scans import scan_ids
from breastrig.storage.rows.shares import snapshot_places
from breastrig.storage.storage import Storage, Unremoved

EVENTS_AT_ONCE = 100  # of some kB each: half a megabyte of SQLite's log
STILL_WRITTEN = "a process still writes to it"

log = logging.getLogger(__name__)


def delete_scan(storage: Storage, scan_id: str) -> list[Unremoved]:
    """Deletes the scan with everything made of it, while nobody runs its fits; what could not be removed."""
    delete_rows(storage, scan_id)
    return remove_files(storage, scan_id)


def delete_rows(storage: Storage, scan_id: str) -> list[str]:
    """Deletes the scan's row and all rows that depend on it; the ids of its fits.  No such scan is no error.

    Their files are in the journal then, for `remove_files`.
    """
    try:
        with storage.database.writing(durable=True) as connection:
            fits = _fits_of(connection, scan_id)
            if is_there(connection, schema.scans, scan_id):
                record_removal(connection, scan_id, _places(connection, scan_id, fits))
                cancel_creations(connection, scan_id)
                _delete_fits(connection, fits)
                forget_scan(connection, scan_id)
                connection.execute(delete(schema.scans).where(schema.scans.c.id == scan_id))
        return fits
    except DBAPIError as error:
        if not storage.is_disk_full(error):
            raise
        return _delete_in_steps(storage, scan_id)


def remove_files(storage: Storage, scan_id: str | None = None) -> list[Unremoved]:
    """Removes what the journal says is to be removed, of one scan or all; what could not be."""
    if scan_id is None:
        _finish_rows(storage)
    places = pending_removals(storage, scan_id)
    left = {one.place: one for one in storage.remove(*places)}
    for place in places:
        kind, _, name = place.partition("/")
        if kind == "fits" and place not in left and not storage.wait_until_free(name, 0.0):
            left[place] = Unremoved(place, storage.files.left_of(place), STILL_WRITTEN)
    gone = [place for place in places if place not in left]

    def write() -> None:
        with storage.database.writing() as connection:
            clear_entries(connection, gone)

    if gone:
        storage.using_reserve(write)
    if places:
        storage.forget_deleted()
        storage.refill_reserve()
    return list(left.values())


def discard(storage: Storage, scan_id: str, *places: str) -> None:
    """Removes files that get no row after all.  What cannot be removed now is tried again later."""
    try:
        with storage.database.writing() as connection:
            record_removal(connection, scan_id, places)
        remove_files(storage, scan_id)
    except SQLAlchemyError as unwritten:  # the next start does the rest
        storage.remove(*places)
        log.error("files that were not kept cannot be struck out: %s", type(unwritten).__name__)


def finish_deletions(storage: Storage) -> list[Unremoved]:
    """At the start of a server: removes what an earlier one has left; what could not be removed.

    Whatever else lies where scans, fits and shares are kept is left alone, and its number said in the log.
    """

    def cancel() -> None:
        with storage.database.writing() as connection:
            cancel_creations(connection)

    storage.using_reserve(cancel)
    left = remove_files(storage)
    with storage.database.reading() as connection:
        shares = snapshot_places(connection)
    known = {
        *map(scan_place, scan_ids(storage)),
        *map(fit_place, fit_ids(storage)),
        *shares,
        *pending_removals(storage),
    }
    unknown = storage.count_unknown(known)
    if unknown:
        log.warning("%d files or folders among those of scans and fits are none of BreastRig's; they stay", unknown)
    return left


def _finish_rows(storage: Storage) -> None:
    """Deletes the rows of scans whose deletion in steps was interrupted."""
    removing = pending_removals(storage)
    for scan_id in set(removing.values()) & scan_ids(storage):
        if scan_place(scan_id) in removing:
            delete_rows(storage, scan_id)


def _delete_in_steps(storage: Storage, scan_id: str) -> list[str]:
    """The same with less room: each step writes little, and the first says what is to be finished in any case."""
    fits = fits_of_scan(storage, scan_id)
    with storage.database.reading() as connection:
        places = _places(connection, scan_id, fits)

    def note() -> None:
        with storage.database.writing(durable=True) as connection:
            record_removal(connection, scan_id, places)
            cancel_creations(connection, scan_id)

    def delete_events(fit_id: str) -> int:
        first = select(schema.events.c.position).where(schema.events.c.fit == fit_id).limit(EVENTS_AT_ONCE)
        with storage.database.writing() as connection:
            return connection.execute(delete(schema.events).where(schema.events.c.position.in_(first))).rowcount

    def delete_fit(fit_id: str) -> None:
        with storage.database.writing() as connection:
            _delete_fits(connection, [fit_id])

    def delete_rest() -> None:
        with storage.database.writing() as connection:
            forget_scan(connection, scan_id)
            connection.execute(delete(schema.scans).where(schema.scans.c.id == scan_id))

    storage.using_reserve(note)
    storage.remove(*places)
    for fit_id in fits:
        while storage.using_reserve(partial(delete_events, fit_id)):
            storage.forget_deleted()
        storage.using_reserve(partial(delete_fit, fit_id))
    storage.using_reserve(delete_rest)
    return fits


def _fits_of(connection: Connection, scan_id: str) -> list[str]:
    return list(connection.execute(select(schema.fits.c.id).where(schema.fits.c.scan == scan_id)).scalars())


def _places(connection: Connection, scan_id: str, fits: list[str]) -> list[str]:
    """Of the scan, of its fits and of all that links show of them."""
    return [scan_place(scan_id), *map(fit_place, fits), *snapshot_places(connection, fits)]


def _delete_fits(connection: Connection, fits: list[str]) -> None:
    connection.execute(delete(schema.fits).where(schema.fits.c.id.in_(fits)))
