"""`breastrig visits CASE -o DIR`: what changed between the visits of one patient, in each stance with two days or more.

DIR gets visits.json, visits.csv, and of each stance visits_STANCE.svg (measures over time with their bands, published
ranges in grey) and a signed map of each change: change_STANCE_N.png, .glb and .ply.  Days are those that
`breastrig case visit` has stored; scans without one are named.
"""

import argparse
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_language, add_output_options
from breastrig.use.cases.case import Case


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", type=Path, metavar="CASE", help="folder of the case")
    add_language(parser)
    add_output_options(parser, "DIR", "folder for the results")


def run(options: argparse.Namespace) -> int:
    """Writes the files, and says each change of a volume; returns 0."""
    case = Case(options.case)
    language, force = options.language, options.force
    found = case.write_visits(options.output, language=language, force=force, asked_to_stop=raise_if_asked)
    numbers = {scan.id: number for number, scan in enumerate(case.scans, start=1)}
    for each in found["asked"]:
        say(
            f"The day of scan {numbers[each['scan']]} ({each['stance']}) is not known; say it with "
            "`breastrig case visit`.",
        )
    for stance in found["stances"]:
        for change in stance["changes"]:
            a, b = (stance["visits"][change[which]] for which in ("earlier", "later"))
            volumes: dict[str, str] = next(
                (row["said"] for row in change["measures"] if row["measure"] == "volume"), {}
            )
            said = [f"{side} {ml} ml" for side, ml in volumes.items() if side != "difference"]
            print(f"{stance['stance']}, {a['date']} to {b['date']}: {', '.join(said) or 'no volume is known'}")
            say(*change["doubts"], *filter(None, [change.get("missing")]))
    return 0
