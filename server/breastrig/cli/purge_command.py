"""What `breastrig purge` does; its words stand in purge_options.py."""

import argparse
import sys

from breastrig.api.settings import without_password
from breastrig.cli.place_options import chosen_location
from breastrig.service.purge import purge
from breastrig.storage.location import Location
from breastrig.storage.storage import Storage


def run(options: argparse.Namespace) -> int:
    """Deletes for good and says how many; returns 0, or 1 when files could not be removed."""
    storage = Storage(chosen_location(options))
    try:
        purged = purge(storage, None if options.all else options.older_than)
    finally:
        storage.close()
    print(f"{_count(purged.scans, 'scan')} deleted from {_place(storage.location)}")
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


def _place(location: Location) -> str:
    return str(location.root) if location.database is None else without_password(location.database)
