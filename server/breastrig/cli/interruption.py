"""Ctrl-C and a request to end: always obeyed, with one line and never with a traceback.

Python's own KeyboardInterrupt gets lost where a library catches everything or Python is in a finaliser.  So while
modules are loaded a signal ends the process at once; afterwards it raises KeyboardInterrupt and is noted as well, for
whoever goes on regardless (`raise_if_asked`).  A second signal ends the process at once.  Only what Python brings in
any case is imported here: each millisecond before `watch` is one in which Python's own traceback would be shown.
"""

import os
import signal
from types import FrameType

NUMBERS = (signal.SIGINT, signal.SIGTERM)

_asked: int | None = None  # the signal that came
_working = False


def watch() -> None:
    """Lets signals end the process at once; a signal that is ignored (nohup, background) stays ignored."""
    global _asked, _working
    _asked, _working = None, False
    for number in NUMBERS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _note)


def work_begins() -> None:
    """Lets the next signal raise KeyboardInterrupt in the main thread."""
    global _working
    _working = True


def raise_if_asked() -> None:
    """Raises KeyboardInterrupt when a signal came, also if the exception was swallowed by someone."""
    if _asked is not None:
        raise KeyboardInterrupt


def exit_code() -> int:
    """128 and the number of the signal, as shells expect it."""
    return 128 + (_asked or signal.SIGINT)


def _note(number: int, _frame: FrameType | None) -> None:
    global _asked
    again, _asked = _asked is not None, number
    if again or not _working:
        os.write(2, b"breastrig: stopped.\n")
        os._exit(exit_code())
    raise KeyboardInterrupt
