"""The options of the actions of `breastrig case`."""

import argparse
from pathlib import Path

from breastrig.cli.options.scan_options import add_answers, add_scan_options
from breastrig.core.assets import packaged_models
from breastrig.core.stances import AUTO, STANCES
from breastrig.use.steps.settings import FIRST


def no_options(_parser: argparse.ArgumentParser) -> None:
    """Adds no options: the case is the only one."""


def create_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--code", default="", help="a code of your own, never a name; by default a random one")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit")
    add_scan_options(parser)
    parser.add_argument("--model", default="", choices=list(packaged_models()), help="packaged model to fit it with")
    parser.add_argument("--again", action="store_true", help="though the same file is a scan of this case already")


def lesions_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="drawn on the image of the scan: NIfTI, NRRD, DICOM SEG or RTSTRUCT"
    )
    add_answers(parser)
    scan_option(parser)


def scan_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--scan", default="", metavar="S", help="the scan: its number or id in `case show`; not needed for an only one"
    )


def landmarks_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    scan_option(parser)


def length_options(parser: argparse.ArgumentParser) -> None:
    given = parser.add_mutually_exclusive_group(required=True)
    given.add_argument(
        "--put",
        nargs=3,
        metavar=("A", "B", "MM"),
        help="two of the scan's landmarks or marks, and the straight way between them as measured on the patient",
    )
    given.add_argument("--remove", action="store_true", help="the size of the scan's file again")
    scan_option(parser)


def fit_options(parser: argparse.ArgumentParser) -> None:
    scan_option(parser)
    parser.add_argument("--stance", default="auto", choices=STANCES, help="stance of the scan")
    parser.add_argument("--preset", default="default", metavar="NAME", help="default or paper")
    parser.add_argument("--drawing", default=FIRST, metavar="NAME", help="as for breastrig fit; or none")
    parser.add_argument("--refine", action=argparse.BooleanOptionalAction, default=True, help="as for breastrig fit")


def predict_options(parser: argparse.ArgumentParser) -> None:
    scan_option(parser)
    parser.add_argument("--stance", required=True, choices=[each for each in STANCES if each != AUTO], help="wanted")


def plan_options(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the plan here")
    what.add_argument("--put", type=Path, metavar="FILE", help="the plan (or drawing) that is to be in force")
    what.add_argument("--undo", type=int, metavar="N", help="put version N in force again")
    parser.add_argument("--version", type=int, metavar="N", help="with -o: an earlier version")
    parser.add_argument("--seen", metavar="ETAG", help="replace only the plan that `case show` has named so")
    parser.add_argument("--same-patient", action="store_true", help="though the file names another patient")
    parser.add_argument("--force", action="store_true", help="with -o: replace a file")
    scan_option(parser)


def visit_options(parser: argparse.ArgumentParser) -> None:
    day = parser.add_mutually_exclusive_group(required=True)
    day.add_argument("--date", metavar="DAY", help="such as 2026-11-29")
    day.add_argument("--remove", action="store_true", help="the day is not known")
    parser.add_argument("--label", default="", help="such as: before, in theatre, 6 weeks")
    scan_option(parser)


def move_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("target", type=Path, metavar="TARGET", help="folder of the other case")
    scan_option(parser)
    parser.add_argument("--again", action="store_true", help="though the same file is a scan of the other case already")


def delete_options(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--scan", default="", metavar="S", help="the scan: its number or id in `case show`")
    what.add_argument("--all", action="store_true", help="the whole case")
