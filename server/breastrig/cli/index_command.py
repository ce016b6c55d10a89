"""`breastrig index DATA`: makes the index of a data folder's cases again, from their folders.

Patients of a data folder of version 0.2.0 become cases first, as at the start of a server.
"""

import argparse
import sys
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.core.errors import BadInput
from breastrig.index.index import Index
from breastrig.service.bring_over import is_early, take_over
from breastrig.storage.data_folder import Ownership, ownership_of
from breastrig.storage.storage import Storage


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", type=Path, metavar="DATA", help="the data folder")


def run(options: argparse.Namespace) -> int:
    """Prints the result; returns 0, or 1 where a case has a damaged document."""
    if ownership_of(options.data) is not Ownership.OURS:
        raise BadInput(f"There is no BreastRig data folder at {options.data}; check the name.")
    _bring_over(options.data)
    index = Index(options.data)
    found = index.rebuild()
    index.close()
    print(f"{found.cases} cases, {found.scans} scans, {found.fits} fits")
    if not found.links_kept:
        say("there was no index to take over: links are closed, sessions are over.")
    if found.busy:
        say(f"{found.busy} cases are being written; they are read at the next look.")
    for case_id in found.unreadable:
        say(f"the case {case_id} has a damaged document; put a copy back.")
    return 1 if found.unreadable else 0


def _bring_over(data: Path) -> None:
    if not is_early(data):
        return
    storage = Storage(data)
    try:
        with storage.exclusive():
            storage.prepare()
            take_over(storage)
    finally:
        storage.close()
    print("the patients of an earlier version are cases now", file=sys.stderr)
