"""The server from which all child processes fork: what it has imported, and its start.

A child finds imported whatever the server has imported, so callers name the modules of their tasks with `preload`;
others of the package it learns from the first task that imports them (learned_modules.py).

It is started so that Ctrl-C on a terminal passes it by.

Ctrl-C goes to every process of the terminal.  A child that is just starting would die of it with a traceback, before
its pool could have it ignore that; and pools end their children anyway.  Processes inherit what is blocked where
they are started, and children have it from the server.
"""

import signal
import sys
from collections.abc import Iterable
from multiprocessing import forkserver, resource_tracker

BEGINS = "breastrig.execution.fork_server_begins"
READY = "breastrig.execution.fork_server_ready"
ALWAYS = (BEGINS, "__main__", "breastrig.execution.processes")  # the last two are what every child looks for first
_named: list[str] = []


def preload(modules: Iterable[str]) -> None:
    """Has the server import these modules; to be called before the first pool.  What is not installed is left out."""
    _named.extend(name for name in modules if name not in _named)


def modules_to_preload() -> list[str]:
    """Those that callers have named; while nobody has named any, all of ours that the program has imported.

    A program's own modules are not all wanted: those of `breastrig serve` bring Flask, which no task needs, and would
    make its start a fifth longer.
    """
    between = _named or sorted(name for name in sys.modules if name.startswith("breastrig."))
    return [*ALWAYS, *(name for name in between if name != READY), READY]


def start_fork_server() -> None:
    """To be called after the first pool was made, which says what the server imports, and before its first task."""
    resource_tracker.ensure_running()  # it would let the signal through again at its start
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
