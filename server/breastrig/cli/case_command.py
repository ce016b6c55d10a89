"""`breastrig case ...`: a patient's folder, with scans, fits and plan, also one that a service serves.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 fitted, but not usable.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from breastrig.cli.cases import actions as actions_of
from breastrig.cli.options.scan_options import add_answers, add_scan_options
from breastrig.core.assets import packaged_models
from breastrig.core.stances import AUTO, STANCES
from breastrig.use.steps.settings import FIRST


def add_options(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    _action(actions, "create", "make a case without scans", actions_of.create, _create_options)
    _action(actions, "add", "read a scan into a case", actions_of.add, _add_options)
    _action(actions, "lesions", "add the lesions of another file to the plan", actions_of.lesions, _lesions_options)
    _action(actions, "landmarks", "replace a scan's landmarks", actions_of.landmarks, _landmarks_options)
    _action(actions, "length", "give a scan its true size", actions_of.length, _length_options)
    _action(actions, "fit", "fit a scan of a case, and keep the fit in it", actions_of.fit, _fit_options)
    _action(actions, "predict", "the patient of a scan in another stance", actions_of.predict, _predict_options)
    _action(actions, "plan", "write the plan into a file, replace it, or undo a change", actions_of.plan, _plan_options)
    _action(actions, "show", "show the contents of a case", actions_of.show, _no_options)
    _action(actions, "list", "the cases of a folder or data folder", actions_of.list_cases, None)
    _action(actions, "rename", "give the patient another code", actions_of.rename, _create_options)
    _action(actions, "move", "move a scan to another case", actions_of.move, _move_options)
    _action(actions, "delete", "delete a scan, or the whole case, for good", actions_of.delete, _delete_options)


def run(options: argparse.Namespace) -> int:
    """Returns the exit code of the action."""
    act: Callable[[argparse.Namespace], int] = options.act
    return act(options)


def _action(
    actions: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    what: str,
    act: Callable[[argparse.Namespace], int],
    add: Callable[[argparse.ArgumentParser], None] | None,
) -> None:
    parser = actions.add_parser(name, help=what, description=what)
    parser.set_defaults(act=act)
    parser.add_argument("case", type=Path, metavar="CASE" if add else "FOLDER", help="folder of the case")
    if add is not None:
        add(parser)


def _no_options(_parser: argparse.ArgumentParser) -> None:
    """Adds no options: the case is the only one."""


def _create_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--code", default="", help="a code of your own, never a name; by default a random one")


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit")
    add_scan_options(parser)
    parser.add_argument("--model", default="", choices=list(packaged_models()), help="packaged model to fit it with")
    parser.add_argument("--again", action="store_true", help="though the same file is a scan of this case already")


def _lesions_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="drawn on the image of the scan: NIfTI, NRRD, DICOM SEG or RTSTRUCT"
    )
    add_answers(parser)
    _scan_option(parser)


def _scan_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--scan", default="", metavar="S", help="the scan: its number or id in `case show`; not needed for an only one"
    )


def _landmarks_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    _scan_option(parser)


def _length_options(parser: argparse.ArgumentParser) -> None:
    given = parser.add_mutually_exclusive_group(required=True)
    given.add_argument(
        "--put",
        nargs=3,
        metavar=("A", "B", "MM"),
        help="two of the scan's landmarks or marks, and the straight way between them as measured on the patient",
    )
    given.add_argument("--remove", action="store_true", help="the size of the scan's file again")
    _scan_option(parser)


def _fit_options(parser: argparse.ArgumentParser) -> None:
    _scan_option(parser)
    parser.add_argument("--stance", default="auto", choices=STANCES, help="stance of the scan")
    parser.add_argument("--preset", default="default", metavar="NAME", help="default or paper")
    parser.add_argument("--drawing", default=FIRST, metavar="NAME", help="as for breastrig fit; or none")
    parser.add_argument("--refine", action=argparse.BooleanOptionalAction, default=True, help="as for breastrig fit")


def _predict_options(parser: argparse.ArgumentParser) -> None:
    _scan_option(parser)
    parser.add_argument("--stance", required=True, choices=[each for each in STANCES if each != AUTO], help="wanted")


def _plan_options(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the plan here")
    what.add_argument("--put", type=Path, metavar="FILE", help="the plan (or drawing) that is to be in force")
    what.add_argument("--undo", type=int, metavar="N", help="put version N in force again")
    parser.add_argument("--version", type=int, metavar="N", help="with -o: an earlier version")
    parser.add_argument("--seen", metavar="ETAG", help="replace only the plan that `case show` has named so")
    parser.add_argument("--same-patient", action="store_true", help="though the file names another patient")
    parser.add_argument("--force", action="store_true", help="with -o: replace a file")
    _scan_option(parser)


def _move_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("target", type=Path, metavar="TARGET", help="folder of the other case")
    _scan_option(parser)
    parser.add_argument("--again", action="store_true", help="though the same file is a scan of the other case already")


def _delete_options(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--scan", default="", metavar="S", help="the scan: its number or id in `case show`")
    what.add_argument("--all", action="store_true", help="the whole case")
