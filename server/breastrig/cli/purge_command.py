"""`breastrig purge`: deletes scans with everything made of them, while no server runs."""

import argparse

from breastrig.api.settings import read_days
from breastrig.cli.data_option import add_data_option, data_folder
from breastrig.jobs.purge import purge
from breastrig.storage.storage import Storage


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("purge", help="delete stored scans and all that was made of them", description=__doc__)
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--all", action="store_true", help="every scan")
    which.add_argument("--older-than", type=days, metavar="DAYS", help="scans uploaded more than so many days ago")
    add_data_option(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Deletes for good and says how many; returns 0."""
    storage = Storage(data_folder(options))
    try:
        count = purge(storage, None if options.all else options.older_than)
    finally:
        storage.close()
    print(f"{count} {'scan' if count == 1 else 'scans'} deleted from {storage.root}")
    return 0


def days(text: str) -> float:
    """A number of days from an option."""
    try:
        return read_days(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text} {error}") from error
