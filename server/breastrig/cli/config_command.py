"""`breastrig config`: the settings that `breastrig serve` would have, and where each one comes from."""

import argparse
import os

from breastrig.api.settings import token_source
from breastrig.cli.options.service_options import add_service_options, service_settings

add_options = add_service_options


def run(options: argparse.Namespace) -> int:
    """Prints one line each; of the token only whether there is one."""
    found = service_settings(options)
    token, source = token_source(found, os.environ)
    lines = [(name, one.shown, one.source) for name, one in found.items()]
    without = "none" if found["no_token"].value else "made at each start"
    lines.append(("token", without if token is None else "set, not shown", source))
    widths = [max(len(line[column]) for line in lines) for column in (0, 1)]
    for name, shown, source in lines:
        print(f"{name:<{widths[0]}}  {shown:<{widths[1]}}  {source}")
    return 0
