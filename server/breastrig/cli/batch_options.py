"""`breastrig batch MANIFEST.csv -o DIR`: many scans, one row per fit.

The first line of the manifest names its columns: scan, and any of landmarks, name, units, stance, preset, drawing,
tumour (several split by blanks) and refine (yes, or no for the model alone), each as the option of `breastrig fit`.  DIR/NAME/ holds what
`breastrig fit` writes; DIR/batch.csv has the numbers of all rows.  A batch that was interrupted goes on when it is
called again: only rows that failed, are missing, or whose files or settings have changed are done.
"""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options

EXAMPLE = """example of a manifest:
  scan,landmarks,name,stance,tumour
  a/standing.ply,a/standing.json,a_standing,standing,"L:10,45,12"
  a/supine.ply,a/supine.json,a_supine,supine,

on two machines, beside a scheduler (dask scheduler --host ADDRESS):
  breastrig worker tcp://ADDRESS:8786
  breastrig batch manifest.csv -o results --scheduler tcp://ADDRESS:8786
"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser(
        "batch",
        help=COMMANDS["batch"],
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("manifest", type=Path, metavar="MANIFEST.csv", help="one scan a row")
    add_output_options(parser, "DIR", "folder for the results")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--jobs", type=int, metavar="N", help="fits at a time (default: one a core, at most 8)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, as in tcp://host:8786")
    parser.add_argument("--again", action="store_true", help="do also the rows that are done")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar, no line for each row")
