"""Measures of one fit, or of two stances of one patient, as JSON, CSV and PDF with a tape sheet of the drawing."""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("report", help=COMMANDS["report"], description=__doc__)
    parser.add_argument(
        "fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote, with or without --with"
    )
    parser.add_argument(
        "--with", dest="other", type=Path, metavar="OUT_B", help="fit of the same patient in another stance"
    )
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="plan or drawing that is shown instead of the fit's own drawing"
    )
    parser.add_argument(
        "--code",
        default="",
        metavar="CODE",
        help="the patient's code, never a name, on every page and in the PDF's name; by default that of the fit",
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig that the fits were made with")
    add_output_options(parser, "DIR", "folder for the three files")
