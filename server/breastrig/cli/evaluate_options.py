"""`breastrig evaluate COHORT -o DIR`: how good is the fit?  Tables, figures and a page from a folder of patients.

Finished work is kept in DIR/work: an interrupted run goes on where it was, and a changed input is measured anew.
"""

import argparse
import os
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options
from breastrig.evaluation.studies.rotation_counts import QUICK_ROTATIONS, ROTATIONS


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("evaluate", help=COMMANDS["evaluate"], description=__doc__)
    parser.add_argument(
        "cohort", type=Path, nargs="?", metavar="COHORT", help="PATIENT/STANCE/{scan.ply, landmarks.json, ...}"
    )
    parser.add_argument("--virtual", action="store_true", help="make the virtual cohort into DIR/cohort and take it")
    parser.add_argument(
        "--warped",
        type=int,
        metavar="N",
        help="make N warped bodies into DIR/warped and take them; a COHORT's patients are warped, too",
    )
    parser.add_argument(
        "--hanging",
        type=float,
        metavar="SHARE",
        help="of the warped bodies, whose breasts hang (0.25); 0 for none, 1 for all",
    )
    parser.add_argument(
        "--painted",
        action="store_true",
        help="paint the virtual cohort into DIR/painted: colour is measured",
    )
    parser.add_argument(
        "--half",
        choices=("choose", "report", "both"),
        help="of the warped bodies or the painted patients; the halves share no source (both)",
    )
    parser.add_argument(
        "--preset",
        action="append",
        metavar="NAME",
        help="default, paper, or a TOML file; may be given several times, the first one is studied (default, paper)",
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    parser.add_argument("--quick", action="store_true", help="Table 1 and the study of the landmarks only")
    parser.add_argument(
        "--rotations",
        type=int,
        metavar="N",
        help=f"random orientations of each scan ({ROTATIONS}, quick {QUICK_ROTATIONS}); 0 for none",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="processes at a time")
    parser.add_argument("--again", action="store_true", help="measure finished work again")
    add_output_options(parser, "DIR", "folder for the results")
