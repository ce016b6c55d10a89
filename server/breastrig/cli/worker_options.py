"""`breastrig worker ADDRESS`: this machine helps a Dask scheduler with the fits of `serve` and `batch`.

Whoever reaches a scheduler or a worker can have any program run there.  Keep both in a network of your own, or give
a tls:// address: certificates come from Dask's own settings (distributed.comm.tls, or the environment's
DASK_DISTRIBUTED__COMM__TLS__...).
"""

import argparse

from breastrig.cli.commands import COMMANDS


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("worker", help=COMMANDS["worker"], description=__doc__)
    parser.add_argument("address", metavar="ADDRESS", help="the scheduler's, as in tcp://host:8786")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="fits that run at once (default: one a core, at most 8)"
    )
