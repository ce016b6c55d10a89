"""Deleting a scan: one rename, from which on nobody can read it; then its files, items and rows.

Whatever is interrupted or fails is finished at the next start or attempt (see cases/removal.py).
"""

import logging
import os
import sqlite3
from contextlib import suppress
from functools import partial

from breastrig.cases import layout, removal
from breastrig.cases.case_folder import CaseFolder, remove_tree
from breastrig.cases.layout import scan_part
from breastrig.core.errors import NotFound
from breastrig.index import questions
from breastrig.index.file import is_full
from breastrig.storage.files import scan_place
from breastrig.storage.storage import Storage, Unremoved

log = logging.getLogger(__name__)


def delete_scan(storage: Storage, scan_id: str) -> list[Unremoved]:
    """Deletes the scan with everything made of it, while nobody runs its fits; what could not be removed.

    No such scan is no error.
    """
    links = storage.index.asked(questions.links_of_scan, scan_id)
    try:
        case = storage.case_of_scan(scan_id)
        left = removal.delete_scan(case, scan_id)
    except NotFound:
        moved = _case_of(storage, scan_id)
        if moved is None:
            return _still_there(storage, scan_id)
        case = moved
        left = removal.delete_scan(case, scan_id)
    try:
        storage.index.making_room(partial(_forget, storage, case.id, links))
    except sqlite3.Error as error:
        if not is_full(error):
            raise
        log.error("the disk is full: what was deleted is still in the index, which nobody is shown")
    storage.index.keep_room()
    return [Unremoved(scan_place(scan_id), one.where, one.reason) for one in left]


def delete_empty_case(storage: Storage, case_id: str) -> None:
    """A case without scans, as other programs make them; no such case is no error."""
    with suppress(NotFound):
        removal.delete_case(storage.case(case_id), empty=True)
        storage.index.refresh(case_id)
        storage.forget_deleted()


def _case_of(storage: Storage, scan_id: str) -> CaseFolder | None:
    """The case of a scan that another program has moved since the index was updated; None where there is none."""
    if layout.ID.fullmatch(scan_id):
        for folder in (storage.root / layout.CASES).glob(f"*/{scan_part(scan_id)}"):
            with suppress(NotFound):
                case = storage.case(folder.parents[1].name)
                if scan_id in case.scan_ids():
                    return case
    return None


def _forget(storage: Storage, case_id: str, links: list[str]) -> None:
    """Deletes the index's rows of what is deleted."""
    storage.index.refresh(case_id)
    with storage.index.writing() as rows:
        for link in links:
            questions.forget_link(rows, link)
    storage.forget_deleted()


def _still_there(storage: Storage, scan_id: str) -> list[Unremoved]:
    """The remains of a scan that is deleted already, after another attempt."""
    if not layout.ID.fullmatch(scan_id):
        return []
    rubbish = storage.root / layout.RUBBISH
    own = [str(each) for each in rubbish.iterdir() if each.name.endswith(f".{scan_id}")]
    own += [str(each) for each in rubbish.iterdir() if (each / layout.SCANS / scan_id).exists()]
    left = removal.sweep(storage.root) if own else []
    places = (*own, scan_id)  # a folder that cannot be moved is still in its case
    return [
        Unremoved(scan_place(scan_id), one.where, one.reason) for one in left if any(p in one.where for p in places)
    ]


def remove_left(storage: Storage) -> list[Unremoved]:
    """Finishes deletions that were interrupted or failed; returns what still cannot be removed."""
    left = swept(storage)
    look(storage)
    return left


def swept(storage: Storage) -> list[Unremoved]:
    """The files that could not be removed in another sweep, without the index."""
    return [Unremoved(one.where, one.where, one.reason) for one in removal.sweep(storage.root)]


def look(storage: Storage) -> None:
    """Takes up what other programs have written and deleted."""
    if storage.index.look():
        storage.index.look()  # forgets links, now that nothing has changed
        storage.forget_deleted()


def count_left(storage: Storage) -> int:
    """The number of scans and cases that are not completely removed."""
    try:
        return len(os.listdir(storage.root / layout.RUBBISH))
    except FileNotFoundError:
        return 0


def finish_deletions(storage: Storage) -> list[Unremoved]:
    """At the start of a server: removes what an earlier one has left; what could not be removed.

    It comes before the index, which needs room.  Whatever else lies where cases are kept is left alone, and its number
    said in the log.  Raises BadSettings when the data folder cannot be written.
    """
    storage.create()
    for entry in (storage.root / layout.INCOMING).iterdir():
        kind, _, name = entry.name.partition(".")
        if kind in ("scans", "fits", "shares") and layout.ID.match(name):  # was being made by a server that was killed
            remove_tree(entry)
    left = swept(storage)
    unknown = sum(
        not layout.ID.fullmatch(entry.name) or not (entry / layout.CASE).is_file()
        for entry in (storage.root / layout.CASES).iterdir()
    )
    if unknown:
        log.warning("%d files or folders among the cases are none of BreastRig's; they stay", unknown)
    return left
