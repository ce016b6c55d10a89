"""`breastrig compare --on OUT FIRST SECOND -o DIR`: two drawings on one scan, superimposed.

For instance the surgeon's own drawing (shown black) and the model's (shown white), or one drawn lying and one that was
carried there.  DIR gets compare.png, compare.csv and compare.json: for each shape that both have the distance in mm,
both ways: mean, 95 % and largest.
"""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("compare", help=COMMANDS["compare"], description=__doc__)
    parser.add_argument("first", type=Path, metavar="FIRST", help="a drawing on the scan, or on the model; black")
    parser.add_argument("second", type=Path, metavar="SECOND", help="another one; white")
    parser.add_argument("--on", dest="fit", type=Path, required=True, metavar="OUT", help="the scan's fit")
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig of the fit, when not the package's")
    add_output_options(parser, "DIR", "folder for the results")
