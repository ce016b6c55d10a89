"""`breastrig presets list|show NAME`: how fits go, as data, to copy and to change (`fit --preset MINE.toml`)."""

import argparse

from breastrig.cli.commands import COMMANDS
from breastrig.fitting.presets.preset_files import preset_names, preset_text


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("presets", help=COMMANDS["presets"], description=__doc__)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    actions.add_parser("list", help="the names of those that come with the package")
    show = actions.add_parser("show", help="one of them as the TOML that it is, with the reason beside each number")
    show.add_argument("name", metavar="NAME", help="default or paper")


def run(options: argparse.Namespace) -> int:
    """Prints; returns 0."""
    print("\n".join(preset_names()) if options.action == "list" else preset_text(options.name), end="")
    if options.action == "list":
        print()
    return 0
