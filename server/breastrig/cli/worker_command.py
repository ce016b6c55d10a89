"""`breastrig worker ADDRESS`: this machine helps a Dask scheduler with the fits of `serve` and `batch`.

Whoever reaches a scheduler or a worker can have any program run there.  Keep both in a network of your own, or give
a tls:// address: certificates come from Dask's own settings (distributed.comm.tls, or the environment's
DASK_DISTRIBUTED__COMM__TLS__...).
"""

import argparse

from breastrig.cli.messages.say import say
from breastrig.core.errors import BadSettings
from breastrig.core.log_lines import set_up_logs
from breastrig.execution.dask_worker import run_worker
from breastrig.execution.limits import FitLimits
from breastrig.service.task_modules import TASK_MODULES


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("address", metavar="ADDRESS", help="the scheduler's, as in tcp://host:8786")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="fits that run at once (default: one a core, at most 8)"
    )


def run(options: argparse.Namespace) -> int:
    """Works until it is stopped (returns 0) or the scheduler is gone (1)."""
    workers = FitLimits().workers if options.workers is None else options.workers
    if workers < 1:
        raise BadSettings("--workers must be 1 or more.")
    set_up_logs("auto")
    stopped = run_worker(options.address, workers, lambda: print("Ready for work.", flush=True), TASK_MODULES)
    if not stopped:
        say(f"The scheduler at {options.address} is gone, or let this worker go.")
    return 0 if stopped else 1
