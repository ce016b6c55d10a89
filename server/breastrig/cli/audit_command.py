"""`breastrig audit ...`: the audit log of a data folder.

Exit codes: 0 done, 1 the log is not as it was written, 2 bad input or usage.
"""

import argparse
import json
from itertools import islice
from pathlib import Path

from breastrig.audit.certificate import certificate
from breastrig.audit.read import check, lines_from, read_mark
from breastrig.cases.layout import MARK
from breastrig.cli.options.output_options import add_language, writing_file
from breastrig.core.errors import BadInput
from breastrig.core.private_files import shown

ACTIONS = {
    "list": "print the lines, the newest last",
    "check": "whether all lines are as they were written",
    "certificate": "a page that certifies a deletion",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, what in ACTIONS.items():
        action = actions.add_parser(name, help=what, description=what)
        action.add_argument("data", type=Path, metavar="DATA", help="the data folder")
        if name == "check":
            action.add_argument(
                "--anchor", default="", metavar="N:SHA256", help="a line that an earlier check has printed"
            )
        elif name == "certificate":
            action.add_argument("id", metavar="ID", help="of a patient or scan that was deleted")
            action.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="the PDF, one A4 page")
            action.add_argument("--force", action="store_true", help="replace a file")
            add_language(action)
        else:
            action.add_argument("--of", default="", metavar="ID", help="lines that name a patient, scan, fit or link")
            action.add_argument(
                "--since", default="", metavar="TIME", help="not older: 2026-11-29, or with T14:30 (UTC)"
            )
            action.add_argument("--last", type=int, metavar="N", help="only so many")


def run(options: argparse.Namespace) -> int:
    """Returns the exit code of the action."""
    if not (options.data / MARK).is_file():
        raise BadInput(f"There is no BreastRig data folder at {shown(options.data)}; check the name.")
    if options.action == "list":
        found = list(islice(lines_from(options.data, options.of, options.since), options.last))
        for line in reversed(found):
            print(json.dumps(line))
        return 0
    if options.action == "certificate":
        content = certificate(options.data, options.id).pdf(options.language)
        with writing_file(options) as write:
            write(content)
        return 0
    checked = check(options.data, read_mark(options.anchor) if options.anchor else None)
    if checked.fault:
        print(f"{checked.fault} The {checked.lines} lines before are as they were written.")
        return 1
    print(f"{checked.lines} lines, as they were written; the last is {checked.end}")
    return 0
