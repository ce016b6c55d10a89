"""Modules that tasks had to import: the fork server imports them too, so that later tasks find them.

Few tasks typeset a report, read a rare format or look at colours, and what these need takes as long to import as all
the rest: too long for every start, and too long for every such task.  So the first one imports it, and has the server
do the same.

In the server `listen` makes a pipe and waits for a signal, which both are inherited by what it forks; `tell` writes the
names.  Only modules of this package are learned, whatever a process says.
"""

import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

from breastrig.execution.one_thread import look_for_libraries

PACKAGE = "breastrig."
LONGEST = 4096  # bytes; a pipe takes so many at once or none

_server: int | None = None  # the process that listens; None: there is none
_ends = (-1, -1)  # of the pipe: where it listens, where it is told
_known: set[str] = set()


def listen() -> None:
    """To be called in the fork server, before it forks."""
    global _server, _ends
    _ends = os.pipe()
    for end in _ends:
        os.set_blocking(end, False)
    signal.signal(signal.SIGUSR1, _learn)
    _server = os.getpid()


def run_and_tell(function: Callable[..., Any], *given: Any) -> Any:
    """What the function returns or raises; then the fork server learns what it had to import."""
    if _server is None or os.getppid() != _server:
        return function(*given)
    _known.update(_imported() if not _known else ())
    try:
        return function(*given)
    finally:
        _tell(_imported() - _known)


def _imported() -> set[str]:
    return {name for name in list(sys.modules) if name.startswith(PACKAGE)}


def _tell(names: set[str]) -> None:
    _known.update(names)
    if names and os.getppid() == _server:  # it may have ended meanwhile, and its number be another's
        try:
            os.write(_ends[1], "".join(f"{name}\n" for name in sorted(names)).encode()[:LONGEST])
            os.kill(os.getppid(), signal.SIGUSR1)
        except OSError:  # the server is told too much at once, or has ended
            pass


def _learn(_number: int, _frame: object) -> None:
    if os.getpid() != _server:
        return
    while True:
        try:
            names = os.read(_ends[0], LONGEST).decode(errors="replace").split("\n")
        except OSError:
            return
        for name in names:
            if name.startswith(PACKAGE):
                try:
                    import_module(name)
                except Exception:  # cut off, or broken: whoever needs it says so
                    continue
        look_for_libraries()
