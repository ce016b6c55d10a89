"""`breastrig backup FILE DATA`: a data folder in one encrypted file (age), also while a server serves it."""

import argparse
from datetime import UTC, datetime
from pathlib import Path

from breastrig.backup.write import back_up
from breastrig.cases.layout import MARK
from breastrig.cli.cases.audited import shell
from breastrig.cli.options.passphrase import add_passphrase_option, passphrase_of
from breastrig.core.errors import BadInput
from breastrig.core.private_files import shown


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="to be made; in a folder, under a name with the time")
    parser.add_argument("data", type=Path, metavar="DATA", help="the data folder")
    add_passphrase_option(parser)


def run(options: argparse.Namespace) -> int:
    """Makes the backup and restores it for a trial; returns 0."""
    if not (options.data / MARK).is_file():
        raise BadInput(f"There is no BreastRig data folder at {shown(options.data)}; check the name.")
    target = options.file
    if target.is_dir():
        target = target / f"breastrig-{datetime.now(UTC):%Y-%m-%dT%H%M%SZ}.age"
    try:
        made = back_up(options.data, target, passphrase_of(options, True), shell())
    except OSError as error:
        raise BadInput(
            f"The backup cannot be written ({error.strerror or error}); free space and begin again."
        ) from error
    size = f"{target.stat().st_size / 1e6:.1f} MB"
    print(f"{made.cases} cases, {made.files} files, {size} in {target}; restored for a trial")
    return 0
