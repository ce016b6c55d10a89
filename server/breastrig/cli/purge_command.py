"""`breastrig purge`: deletes scans with everything made of them, while no server runs."""

import argparse
from contextlib import suppress
from dataclasses import dataclass
from datetime import timedelta

from breastrig.api.settings import read_days
from breastrig.audit.deletions import deletion
from breastrig.audit.log import AuditLog
from breastrig.cases import layout, removal
from breastrig.cases.case_folder import CaseFolder
from breastrig.cli.cases.audited import shell
from breastrig.cli.messages.say import say
from breastrig.cli.options.service_options import add_setting_options, checked, chosen_data_folder
from breastrig.core import wall_clock
from breastrig.core.errors import BadInput, BadSettings, NotFound
from breastrig.service.bring_over import is_early, take_over
from breastrig.storage.data_folder import Ownership, ownership_of
from breastrig.storage.deletion import finish_deletions, look, swept
from breastrig.storage.storage import Storage, Unremoved, iso_utc


def add_options(parser: argparse.ArgumentParser) -> None:
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--all", action="store_true", help="every scan")
    which.add_argument(
        "--older-than", type=checked(read_days), metavar="DAYS", help="scans uploaded more than so many days ago"
    )
    add_setting_options(parser, ["data"])


def run(options: argparse.Namespace) -> int:
    """Deletes for good and says how many; returns 0, or 1 when something is left."""
    storage = Storage(chosen_data_folder(options))
    try:
        purged = purge(storage, None if options.all else read_days(options.older_than))
    finally:
        storage.close()
    print(f"{_count(purged.scans, 'scan')} deleted from {storage.root}")
    for left in purged.left:
        say(f"{left.where} cannot be removed ({left.reason})")
    if purged.left:
        say(
            f"{_count(len(purged.left), 'folder')} of deleted scans could not be removed; mend what is in "
            "the way and call purge again.",
        )
    say(*purged.trouble)
    return 1 if purged.left or purged.trouble else 0


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


@dataclass(frozen=True)
class Purged:
    scans: int  # that were deleted
    left: tuple[Unremoved, ...]  # files of these, or of scans that were deleted before, that cannot be removed
    trouble: tuple[str, ...] = ()  # sentences


def purge(storage: Storage, older_than_days: float | None) -> Purged:
    """Deletes the scans that are older (None: all) with everything made of them.

    They are found without the index, which needs room on a full disk.  Raises BadSettings when there is no such data
    folder or a server holds it.
    """
    if ownership_of(storage.root) is not Ownership.OURS:
        raise BadSettings(f"There is no BreastRig data folder at {storage.root}; name it with --data.")
    with storage.exclusive():
        finish_deletions(storage)
        if is_early(storage.root):
            storage.prepare()
            take_over(storage)
        before = None if older_than_days is None else iso_utc(wall_clock.now() - timedelta(days=older_than_days))
        deleted, trouble = 0, []
        for folder in sorted((storage.root / layout.CASES).iterdir()):
            if layout.ID.fullmatch(folder.name) and (folder / layout.CASE).is_file():
                try:
                    deleted += _purge_case(CaseFolder(folder), before, AuditLog(storage.root))
                except BadInput as damaged:
                    trouble.append(f"{folder}: {damaged}")
        left = swept(storage)
        try:
            storage.prepare()
            look(storage)
            storage.forget_deleted()
        except BadSettings as error:
            trouble.append(f"{error} What is deleted is named in the index until the next start.")
    return Purged(deleted, tuple(left), tuple(trouble))


def _purge_case(case: CaseFolder, before: str | None, log: AuditLog) -> int:
    """Deletes the scans that came before a time (None: the case); how many they were.  Raises BadInput."""
    scans = case.scan_ids()
    if before is None:
        with deletion(log, shell(), "purge", case.path):
            removal.delete_case(case)
        return len(scans)
    old = [scan_id for scan_id in scans if case.scan(scan_id).created_at < before]
    for scan_id in old:
        with suppress(NotFound), deletion(log, shell(), "purge", case.path, scan_id):  # or another was quicker
            removal.delete_scan(case, scan_id)
    return len(old)
