"""The server from which all child processes fork, started so that Ctrl-C on a terminal passes it by.

Ctrl-C goes to every process of the terminal.  A child that is just starting would die of it with a traceback, before
its pool could have it ignore that; and pools end their children anyway.  Processes inherit what is blocked where
they are started, and children have it from the server.
"""

import signal
from multiprocessing import forkserver, resource_tracker


def start_fork_server() -> None:
    """To be called after the first pool was made, which says what the server imports, and before its first task."""
    resource_tracker.ensure_running()  # it would let the signal through again at its start
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
