"""`breastrig presets list|show NAME`: the settings of fits as data, to copy and change (`fit --preset MINE.toml`)."""

import argparse

from breastrig.fitting.recipe import preset_names, preset_text


def add_options(parser: argparse.ArgumentParser) -> None:
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
