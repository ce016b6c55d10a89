"""`breastrig case ...`: a patient's folder, with scans, fits and plan, also one that a service serves.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 fitted, but not usable.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from breastrig.cli.cases import actions
from breastrig.cli.cases import options as options_of
from breastrig.cli.cases.audited import audited

Action = Callable[[argparse.Namespace], int]
ACTIONS: dict[str, tuple[str, Action, Callable[[argparse.ArgumentParser], None]]] = {
    "create": ("make a case without scans", actions.create, options_of.create_options),
    "add": ("read a scan into a case", actions.add, options_of.add_options),
    "lesions": ("add the lesions of another file to the plan", actions.lesions, options_of.lesions_options),
    "landmarks": ("replace a scan's landmarks", actions.landmarks, options_of.landmarks_options),
    "length": ("give a scan its true size", actions.length, options_of.length_options),
    "visit": ("say on which day a scan was taken", actions.visit, options_of.visit_options),
    "fit": ("fit a scan of a case, and keep the fit in it", actions.fit, options_of.fit_options),
    "predict": ("the patient of a scan in another stance", actions.predict, options_of.predict_options),
    "plan": ("write the plan into a file, replace it, or undo a change", actions.plan, options_of.plan_options),
    "show": ("show the contents of a case", actions.show, options_of.no_options),
    "list": ("the cases of a folder or data folder", actions.list_cases, options_of.no_options),
    "rename": ("give the patient another code", actions.rename, options_of.create_options),
    "move": ("move a scan to another case", actions.move, options_of.move_options),
    "delete": ("delete a scan, or the whole case, for good", actions.delete, options_of.delete_options),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    parsers = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (what, _, add) in ACTIONS.items():
        action = parsers.add_parser(name, help=what, description=what)
        place = "FOLDER" if name == "list" else "CASE"
        action.add_argument("case", type=Path, metavar=place, help="folder of the case")
        add(action)


def run(options: argparse.Namespace) -> int:
    """Returns the exit code of the action."""
    with audited(options):
        return ACTIONS[options.action][1](options)
