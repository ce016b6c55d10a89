"""A fit for other programs: the drawing as lines (GLB, OBJ, PLY), the model as a closed surface (PLY, STL) with its
landmarks, lines, regions and caps as named sets of vertices (JSON)."""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("export", help=COMMANDS["export"], description=__doc__)
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="plan or drawing that is exported instead of the fit's own drawing"
    )
    parser.add_argument(
        "--with",
        dest="other",
        type=Path,
        metavar="OUT_B",
        help="fit of the same patient from which the plan is carried too",
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig that the fit was made with")
    add_output_options(parser, "DIR", "folder for the files")
