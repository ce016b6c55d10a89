"""The passphrase of a backup: typed, in a file or the environment; never an option, which other users could read."""

import argparse
import getpass
import os
import sys
from pathlib import Path

from breastrig.core.errors import BadInput
from breastrig.core.private_files import read_ordinary, shown

VARIABLE = "BREASTRIG_PASSPHRASE"
SHORTEST = 12
MOST_BYTES = 4096


def add_passphrase_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--passphrase-file",
        type=Path,
        metavar="FILE",
        help=f"its first line is the passphrase (default {VARIABLE}, else it is asked for)",
    )


def passphrase_of(options: argparse.Namespace, is_new: bool) -> str:
    """The passphrase; a new one is typed twice and has at least twelve characters.  Raises BadInput."""
    given = os.environ.get(VARIABLE, "")
    if options.passphrase_file is not None:
        try:
            given = read_ordinary(options.passphrase_file, MOST_BYTES).decode().partition("\n")[0].strip("\r")
        except (OSError, UnicodeDecodeError) as error:
            raise BadInput(f"{shown(options.passphrase_file)} holds no passphrase; check the file.") from error
    elif not given:
        if not sys.stdin.isatty():
            raise BadInput(f"There is nobody to type the passphrase; give --passphrase-file or {VARIABLE}.")
        given = getpass.getpass("Passphrase: ")
        if is_new and getpass.getpass("Once more: ") != given:
            raise BadInput("The two passphrases differ; begin again.")
    if not given or (is_new and len(given) < SHORTEST):
        raise BadInput(f"The passphrase is too short: it has at least {SHORTEST} characters, best five random words.")
    return given
