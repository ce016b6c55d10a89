"""`breastrig backup DATA -o FOLDER`: the patients of a service's data folder as cases, a folder each.

While no server runs.  Patients that are in FOLDER already are left as they are.
"""

import argparse
import os
from pathlib import Path

from breastrig.cases.layout import INCOMING
from breastrig.cli.interruption import raise_if_asked
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.private_files import private_folder, shown
from breastrig.service.bring_over import bring_over
from breastrig.storage.data_folder import Ownership, ownership_of
from breastrig.storage.storage import Storage


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", type=Path, metavar="DATA", help="the service's data folder")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER", help="folder for the cases")
    parser.add_argument("--code", action="append", metavar="CODE", help="this patient alone; may be given again")


def run(options: argparse.Namespace) -> int:
    """Writes the cases and prints their number; returns 0."""
    data, folder = options.data, options.output.absolute()
    if ownership_of(data) is not Ownership.OURS:
        raise BadInput(f"There is no BreastRig data folder at {shown(data)}; check the name.")
    if folder == data.absolute() or data.absolute() in folder.parents:
        raise BadInput("A backup is kept elsewhere than in the data folder; choose another folder with -o.")
    storage = Storage(data)
    incoming = folder / f".{INCOMING}"
    try:
        with storage.exclusive():
            storage.prepare()
            private_folder(folder)
            found = bring_over(storage, folder, incoming, options.code, raise_if_asked)
    finally:
        storage.close()
        if incoming.is_dir() and not os.listdir(incoming):
            incoming.rmdir()
    if options.code and not (found.cases or found.there):
        raise NotFound(f"No patient has the code {', '.join(options.code)}; the page lists them.")
    print(f"{len(found.cases)} cases with {found.scans} scans and {found.fits} fits in {options.output}")
    if found.there:
        print(f"{len(found.there)} were there already and are as they were")
    return 0
