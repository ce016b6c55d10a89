"""Deleting and moving scans: one rename decides, and what is interrupted is finished by the next sweep.

rubbish/CASE.SCAN/   the scan is deleted; its files, items and versions are being removed
rubbish/CASE.SCAN    a file: the scan is being moved; its items are to be where the scan is
rubbish/CASE/        the case is deleted
cases/CASE/.new      the case is made for a scan that is being moved; without that scan there is no such patient
"""

import os
from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from breastrig.cases import layout
from breastrig.cases.case_folder import COMING, CaseFolder, new_case, remove_tree, sync_file
from breastrig.cases.fits import is_at_work
from breastrig.cases.layout import scan_part
from breastrig.cases.of_scans import forget_same, say_same
from breastrig.cases.plans import forget_items, renamed, stored_plan, write_plan
from breastrig.cases.writing import FULL, LOCK, locked, put, sync_folder, writing
from breastrig.core.errors import Conflict, NeedsYes, NotFound
from breastrig.core.scratch import remove_abandoned

FROM, TO = b"from", b"to"  # in the file of a scan that is being moved
AT_WORK = "A fit of this scan is running; cancel it or wait for its end, then move the scan."


@dataclass(frozen=True)
class Left:
    """A deleted file that could not be removed."""

    where: str  # for people
    reason: str


def delete_scan(case: CaseFolder, scan_id: str) -> list[Left]:
    """Deletes the scan with everything made of it, and the case when it was the last; what could not be removed.

    It is deleted for all who look from the rename on.  Nobody may be at work on its fits.  Raises NotFound where it is
    not here, nor what is left of it: it may be of another case by now.
    """
    with case.writing():
        if case.around.marks().get(scan_id):
            return _finish_scan(case, scan_id)
        case.check_scan(scan_id)
        if case.scan_ids() == {scan_id}:
            return _delete_case(case)
        _put_away(case, scan_id)
        return _finish_scan(case, scan_id)


def delete_case(case: CaseFolder, empty: bool = False) -> list[Left]:
    """Deletes the case; returns what could not be removed. No such case is no error."""
    try:
        with case.writing():
            return [] if empty and case.scan_ids() else _delete_case(case)
    except NotFound:
        return []


def move_scan(
    source: CaseFolder, scan_id: str, target: CaseFolder, again: bool = False, same_as: Collection[str] = ()
) -> None:
    """The scan is of the other case from then on, and with it what was planned on it; a case goes with its last scan.

    `same_as`: of these scans of the target a person has said that they are of the same patient, whatever the bodies
    say; what was said of it before goes.  Raises NotFound, Conflict while a fit of it runs, NeedsYes where the other
    case has a scan of the same file and nobody said `again`.
    """
    with _both(source, target):
        _move(source, scan_id, target, again, same_as)


def move_to_new(source: CaseFolder, scan_id: str, path: Path, code: str) -> CaseFolder:
    """The scan is of a new case of that code and of the same group from then on, as `move_scan`.

    Raises likewise, and OSError.
    """
    with ExitStack() as stack:
        with new_case(path, code, source.document().group) as folder:
            put(folder, layout.NEW, b"")
            stack.enter_context(locked(folder))  # nobody else writes there until the scan has come
        target = CaseFolder(path)
        try:
            with source.writing():
                _move(source, scan_id, target, False, ())
        except BaseException:
            if not target.scan_ids():
                _delete_case(target)
            raise
        (target.path / layout.NEW).unlink()
    return target


def _move(source: CaseFolder, scan_id: str, target: CaseFolder, again: bool, same_as: Collection[str]) -> None:
    """Under `writing` of both."""
    document = source.scan(scan_id)
    for other in same_as:
        if other not in target.scan_ids():
            raise NotFound("One of these scans is none of this patient's.")
    if source.path == target.path:
        say_same(target, scan_id, same_as)
        return
    if is_at_work(source, scan_id):
        raise Conflict(AT_WORK)
    if not again and any(one.document.sha256 == document.sha256 for one in target.scans()):
        raise NeedsYes("This scan is already here: the same file is one of this patient's scans", "again")
    _mark(source, scan_id, FROM)
    _mark(target, scan_id, TO)
    here = stored_plan(source)
    moved = [item for item in here.items if item.scan == scan_id]
    if moved:
        there = stored_plan(target)
        write_plan(target, [*there.items, *renamed(moved, there.items)], there.whole, here.sizes)
    place = target.path / scan_part(scan_id)
    place.parent.mkdir(mode=0o700, exist_ok=True)
    os.rename(source.scan_folder(scan_id), place)
    sync_folder(place.parent)
    sync_folder(source.path / layout.SCANS)
    forget_same(target, scan_id)
    say_same(target, scan_id, same_as)
    if not source.scan_ids():
        _delete_case(source)
    else:
        _finish_scan(source, scan_id)
    _finish_scan(target, scan_id)


def finish(case: CaseFolder) -> list[Left]:
    """Finishes interrupted deletions and moves of the case's scans; returns what could not be removed."""
    if not case.around.marks():
        return []
    try:
        with case.writing():
            marks = case.around.marks()
            goes = any(deleted or case.around.away(scan).read_bytes() == FROM for scan, deleted in marks.items())
            left = [one for scan_id in sorted(marks) for one in _finish_scan(case, scan_id)]
            return left + _delete_case(case) if goes and not case.scan_ids() else left
    except NotFound:
        return []


def sweep(root: Path) -> list[Left]:
    """Finishes what was interrupted in a data folder; what could not be removed.

    Only names of our form are touched: what another program has put there stays.
    """
    left = []
    rubbish, cases = root / layout.RUBBISH, root / layout.CASES
    if (root / layout.INCOMING).is_dir():
        remove_abandoned(root / layout.INCOMING, COMING)
    for name in sorted(os.listdir(rubbish)) if rubbish.is_dir() else ():
        case_id, _, scan_id = name.partition(".")
        if not layout.ID.fullmatch(case_id) or (scan_id and not layout.ID.fullmatch(scan_id)):
            continue
        try:
            case = CaseFolder(cases / case_id)
        except NotFound:  # it has gone, with whatever was on the way
            left += _removed(rubbish / name)
            continue
        left += finish(case) if scan_id else delete_case(case)
    for folder in sorted(cases.iterdir()) if cases.is_dir() else ():
        if not layout.ID.fullmatch(folder.name) or not (folder / LOCK).is_file():
            continue
        if not (folder / layout.CASE).exists():
            left += _removed(folder)  # the rest of a deleted case
        elif (folder / layout.NEW).exists():
            left += _finish_new(folder)
    return left


def _finish_new(folder: Path) -> list[Left]:
    """Removes a case that was made for a scan that has not come."""
    with suppress(NotFound, Conflict), writing(folder, 0.0):  # who makes it holds it
        case = CaseFolder(folder)
        if not case.scan_ids():
            return _delete_case(case)
        (folder / layout.NEW).unlink(missing_ok=True)
    return []


def _put_away(case: CaseFolder, scan_id: str) -> None:
    """Marks the scan as deleted. Raises OSError when that could not be recorded."""
    away = case.around.away(scan_id)
    away.parent.mkdir(mode=0o700, exist_ok=True)
    if os.path.lexists(away):
        remove_tree(away)
    try:
        os.rename(case.scan_folder(scan_id), away)
        sync_folder(case.path / layout.SCANS)
    except OSError:  # something is mounted there: an empty folder of that name says the same
        away.mkdir(mode=0o700)
    sync_folder(away.parent)


def _finish_scan(case: CaseFolder, scan_id: str) -> list[Left]:
    """Removes the files and items of a scan that is not here. Under `writing`; may be repeated."""
    mark = case.around.away(scan_id)
    if scan_id in case.scan_ids():  # it was moved here
        mark.unlink(missing_ok=True)
        return []
    left = []
    if mark.is_dir():
        left = [*_removed(case.scan_folder(scan_id)), *_emptied(mark)]
    try:
        forget_items(case, scan_id)
        forget_same(case, scan_id)
    except OSError as error:
        if error.errno not in FULL:
            raise
        return left  # nobody sees what is left of it, and the next sweep finds the mark
    if left:
        return left
    if mark.is_dir():
        mark.rmdir()
    else:
        mark.unlink(missing_ok=True)
    return []


def _delete_case(case: CaseFolder) -> list[Left]:
    """Marks the case as deleted, under `writing`: its folder, or its document, gets another name."""
    root = layout.data_folder_of(case.path)
    if root is None or os.name == "nt":  # Windows renames no folder in which a file is open
        (case.path / layout.CASE).unlink()
        sync_folder(case.path)
        return _removed(case.path)
    rubbish = root / layout.RUBBISH
    rubbish.mkdir(mode=0o700, exist_ok=True)
    away = rubbish / case.id
    if os.path.lexists(away):
        remove_tree(away)
    try:
        os.rename(case.path, away)
        sync_folder(case.path.parent)
    except OSError:
        (case.path / layout.CASE).unlink()  # something is mounted there: without it this is no case
    left = [*_removed(case.path), *_removed(away)]
    for scan_id in case.around.marks():
        left += _removed(case.around.away(scan_id))
    return left


def _mark(case: CaseFolder, scan_id: str, role: bytes) -> None:
    """Says that the scan is being moved from or to this case; an empty file, of who was killed here, says too little
    to delete a case."""
    mark = case.around.away(scan_id)
    mark.parent.mkdir(mode=0o700, exist_ok=True)
    mark.write_bytes(role)
    sync_file(mark)
    sync_folder(mark.parent)


@contextmanager
def _both(one: CaseFolder, other: CaseFolder) -> Iterator[None]:
    """Holds both for changes, always in the same order."""
    with ExitStack() as stack:
        for path in sorted({one.path, other.path}):
            stack.enter_context(writing(path))
        yield


def _emptied(folder: Path) -> list[Left]:
    """Removes the contents of a folder; returns what could not be removed."""
    return [one for entry in sorted(folder.iterdir()) for one in _removed(entry)]


def _removed(path: Path) -> list[Left]:
    try:
        remove_tree(path)
    except OSError as error:
        return [Left(str(path), error.strerror or type(error).__name__)]
    return []
