"""`breastrig case ...`: a patient's folder, with scans, fits and plan, also one that a service serves.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 fitted, but not usable.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from breastrig.cli.cases import actions as actions_of
from breastrig.cli.cases import options as options_of
from breastrig.cli.cases.audited import audited


def add_options(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    _action(actions, "create", "make a case without scans", actions_of.create, options_of.create_options)
    _action(actions, "add", "read a scan into a case", actions_of.add, options_of.add_options)
    _action(
        actions,
        "lesions",
        "add the lesions of another file to the plan",
        actions_of.lesions,
        options_of.lesions_options,
    )
    _action(actions, "landmarks", "replace a scan's landmarks", actions_of.landmarks, options_of.landmarks_options)
    _action(actions, "length", "give a scan its true size", actions_of.length, options_of.length_options)
    _action(actions, "visit", "say on which day a scan was taken", actions_of.visit, options_of.visit_options)
    _action(actions, "fit", "fit a scan of a case, and keep the fit in it", actions_of.fit, options_of.fit_options)
    _action(
        actions, "predict", "the patient of a scan in another stance", actions_of.predict, options_of.predict_options
    )
    _action(
        actions,
        "plan",
        "write the plan into a file, replace it, or undo a change",
        actions_of.plan,
        options_of.plan_options,
    )
    _action(actions, "show", "show the contents of a case", actions_of.show, options_of.no_options)
    _action(actions, "list", "the cases of a folder or data folder", actions_of.list_cases, None)
    _action(actions, "rename", "give the patient another code", actions_of.rename, options_of.create_options)
    _action(actions, "move", "move a scan to another case", actions_of.move, options_of.move_options)
    _action(
        actions, "delete", "delete a scan, or the whole case, for good", actions_of.delete, options_of.delete_options
    )


def run(options: argparse.Namespace) -> int:
    """Returns the exit code of the action."""
    act: Callable[[argparse.Namespace], int] = options.act
    with audited(options):
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
