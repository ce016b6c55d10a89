"""`breastrig presets list|show NAME`: how fits go, as data, to copy and to change (`fit --preset MINE.toml`)."""

import argparse

from breastrig.cli.commands import COMMANDS


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("presets", help=COMMANDS["presets"], description=__doc__)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    actions.add_parser("list", help="the names of those that come with the package")
    show = actions.add_parser("show", help="one of them as the TOML that it is, with the reason beside each number")
    show.add_argument("name", metavar="NAME", help="default or paper")
