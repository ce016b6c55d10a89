"""`breastrig purge`: deletes scans with everything made of them, while no server runs."""

import argparse

from breastrig.api.settings import read_days
from breastrig.cli.commands import COMMANDS
from breastrig.cli.place_options import add_place_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("purge", help=COMMANDS["purge"], description=__doc__)
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--all", action="store_true", help="every scan")
    which.add_argument("--older-than", type=days, metavar="DAYS", help="scans uploaded more than so many days ago")
    add_place_options(parser)


def days(text: str) -> float:
    """A number of days from an option."""
    try:
        return read_days(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text} {error}") from error
