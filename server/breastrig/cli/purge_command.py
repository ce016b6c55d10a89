"""`breastrig purge`: deletes scans with everything made of them, while no server runs."""

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass

from breastrig.api.settings import read_days
from breastrig.cli.service_options import add_setting_options, chosen_data_folder
from breastrig.core.errors import BadSettings
from breastrig.service.sweep import overdue
from breastrig.storage.data_folder import Ownership, ownership_of
from breastrig.storage.deletion import delete_rows, finish_deletions, remove_files
from breastrig.storage.rows.scans import scan_ids
from breastrig.storage.storage import Storage, Unremoved


def add_options(parser: argparse.ArgumentParser) -> None:
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--all", action="store_true", help="every scan")
    which.add_argument("--older-than", type=days, metavar="DAYS", help="scans uploaded more than so many days ago")
    add_setting_options(parser, ["data"])


def days(text: str) -> float:
    """A number of days from an option."""
    try:
        return read_days(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text} {error}") from error


def run(options: argparse.Namespace) -> int:
    """Deletes for good and says how many; returns 0, or 1 when files could not be removed."""
    storage = Storage(chosen_data_folder(options))
    try:
        purged = purge(storage, None if options.all else options.older_than)
    finally:
        storage.close()
    print(f"{_count(purged.scans, 'scan')} deleted from {storage.root}")
    for left in purged.left:
        print(f"breastrig: {left.where} cannot be removed ({left.reason})", file=sys.stderr)
    if purged.left:
        print(
            f"breastrig: {_count(len(purged.left), 'folder')} of deleted scans could not be removed; mend what is in "
            "the way and call purge again.",
            file=sys.stderr,
        )
    return 1 if purged.left else 0


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


@dataclass(frozen=True)
class Purged:
    scans: int  # that were deleted
    left: tuple[Unremoved, ...]  # files of these, or of scans that were deleted before, that cannot be removed


def purge(storage: Storage, older_than_days: float | None) -> Purged:
    """Deletes the scans that are older (None: all) with everything made of them.

    Raises BadSettings when there is no such data folder or a server holds it.
    """
    if ownership_of(storage.root) is not Ownership.OURS:
        raise BadSettings(f"There is no BreastRig data folder at {storage.root}; name it with --data.")
    with storage.exclusive():
        storage.prepare()
        finish_deletions(storage)
        every = older_than_days is None
        chosen: Iterable[str] = scan_ids(storage) if every else overdue(storage, older_than_days or 0.0)
        scans = list(chosen)
        for scan_id in scans:
            delete_rows(storage, scan_id)
            remove_files(storage, scan_id)
        left = remove_files(storage)
        storage.refill_reserve()
    return Purged(len(scans), tuple(left))
