"""The server from which all child processes fork, and what it has imported.

A child finds imported whatever the server has imported, so callers name the modules of their tasks with `preload`.
The server is started with SIGINT blocked: Ctrl-C on a terminal goes to every process of it, and a child that is just
starting would end with a traceback; pools end their children anyway.
"""

import signal
import sys
from collections.abc import Iterable
from multiprocessing import forkserver, resource_tracker

ALWAYS = ("__main__", "breastrig.execution.processes")  # what every child looks for first
_named: list[str] = []


def preload(modules: Iterable[str]) -> None:
    """Has the server import these modules; to be called before the first pool.  What is not installed is left out."""
    _named.extend(name for name in modules if name not in _named)


def modules_to_preload() -> list[str]:
    """Those that callers have named; while nobody has named any, all of ours that the program has imported.

    A program's own modules are not all wanted: those of `breastrig serve` bring Flask, which no task needs, and would
    make its start a fifth longer.
    """
    return [*ALWAYS, *(_named or sorted(name for name in sys.modules if name.startswith("breastrig.")))]


def start_fork_server() -> None:
    """To be called after the first pool was made, which says what the server imports, and before its first task."""
    resource_tracker.ensure_running()  # it would let the signal through again at its start
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
