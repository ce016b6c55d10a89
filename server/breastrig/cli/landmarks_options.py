"""`breastrig landmarks SCAN -o FILE`: proposes all landmarks of the model on a scan, to be checked by a person."""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options
from breastrig.core.units import METRES_PER_UNIT


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("landmarks", help=COMMANDS["landmarks"], description=__doc__)
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    add_output_options(parser, "FILE", ".json (with a confidence and a 90 %% radius each), .csv, .pp, .mrk.json")
