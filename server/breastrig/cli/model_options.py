"""`breastrig model info|check|bind|build`: describe a rig, prove it sound, bind what is known to it, build ours."""

import argparse
from pathlib import Path

from breastrig.cli.commands import COMMANDS


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("model", help=COMMANDS["model"], description=__doc__)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, what in (
        ("info", "bones, shapes, landmarks and drawings of a rig"),
        ("check", "every rule that a rig must keep, one line each"),
        ("bind", "says that NAME.known beside the rig, what was estimated for it, is of the rig as it is now"),
    ):
        action = actions.add_parser(name, help=what)
        action.add_argument("--model", type=Path, metavar="GLB", help="another rig than the package's torso")
    actions.add_parser("build", help="build the torso from its sources (source checkout only)")
