"""`breastrig ink SCAN -o FILE`: finds lines that were drawn with a marker on the skin, in the scan's colours."""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options
from breastrig.core.units import METRES_PER_UNIT


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("ink", help=COMMANDS["ink"], description=__doc__)
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit; with its colours")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    add_output_options(parser, "FILE", ".json, a drawing; each shape says its kind, marker and length")
