"""`breastrig serve`: the service and its page, until Ctrl-C or SIGTERM."""

import argparse

from breastrig.cli.commands import COMMANDS
from breastrig.cli.service_options import add_service_options


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("serve", help=COMMANDS["serve"], description=__doc__)
    add_service_options(parser)
