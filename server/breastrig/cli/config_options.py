"""`breastrig config`: the settings that `breastrig serve` would have, and where each one comes from."""

import argparse

from breastrig.cli.commands import COMMANDS
from breastrig.cli.service_options import add_service_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("config", help=COMMANDS["config"], description=__doc__)
    add_service_options(parser)
