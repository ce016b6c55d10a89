"""`breastrig restore FILE DATA`: a backup into a new data folder, without patients who were deleted since."""

import argparse
from pathlib import Path

from breastrig.backup.restore import restore
from breastrig.cli.cases.audited import shell
from breastrig.cli.messages.say import say
from breastrig.cli.options.passphrase import add_passphrase_option, passphrase_of
from breastrig.core.errors import BadInput
from breastrig.core.private_files import is_ordinary, shown


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="that breastrig backup has made")
    parser.add_argument("data", type=Path, metavar="DATA", help="a new or empty folder")
    parser.add_argument(
        "--audit", type=Path, metavar="LOG", help="the newest audit log: the old data folder, or a file of its lines"
    )
    parser.add_argument("--with-deleted", action="store_true", help="patients too that were deleted since")
    add_passphrase_option(parser)


def run(options: argparse.Namespace) -> int:
    """Restores the backup and lists what was deleted since; returns 0."""
    if not is_ordinary(options.file):
        raise BadInput(f"There is no file {shown(options.file)}; check the name.")
    if options.with_deleted and options.audit is None:
        raise BadInput("--with-deleted needs --audit, which says who was deleted.")
    try:
        found = restore(
            options.file,
            options.data,
            passphrase_of(options, False),
            shell(),
            options.audit,
            options.with_deleted,
        )
    except OSError as error:
        raise BadInput(
            f"The backup cannot be restored ({error.strerror or error}); mend that and begin again."
        ) from error
    print(f"{found.cases} cases of {found.made_at} in {options.data}; links are closed, sessions are over")
    for each in found.deleted:
        print(f"{each} was deleted since, and is {'here again' if options.with_deleted else 'left out'}")
    if options.audit is None:
        say("patients who were deleted since are here again: give --audit to find them.")
    return 0
