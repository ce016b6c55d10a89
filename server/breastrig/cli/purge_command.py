"""`breastrig purge`: deletes scans with everything made of them, while no server runs."""

import argparse

from breastrig.api.settings import read_days, without_password
from breastrig.cli.place_options import add_place_options, chosen_location
from breastrig.jobs.purge import purge
from breastrig.storage.location import Location
from breastrig.storage.storage import Storage


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("purge", help="delete stored scans and all that was made of them", description=__doc__)
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--all", action="store_true", help="every scan")
    which.add_argument("--older-than", type=days, metavar="DAYS", help="scans uploaded more than so many days ago")
    add_place_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Deletes for good and says how many; returns 0."""
    storage = Storage(chosen_location(options))
    try:
        count = purge(storage, None if options.all else options.older_than)
    finally:
        storage.close()
    print(f"{count} {'scan' if count == 1 else 'scans'} deleted from {_place(storage.location)}")
    return 0


def _place(location: Location) -> str:
    return str(location.root) if location.database is None else without_password(location.database)


def days(text: str) -> float:
    """A number of days from an option."""
    try:
        return read_days(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text} {error}") from error
