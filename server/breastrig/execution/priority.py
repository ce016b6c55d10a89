"""Who goes first where there are fewer processors than tasks.

Behind an upload sits a person who can do nothing before it is read; a fit, a report or a search shows how far it is,
and others go on beside it.  So what is no upload runs at a lower priority than uploads and the server itself.  It is
the system's scheduler that shares the processors: a task that may use one alone loses nothing.
"""

import os
from collections.abc import Callable
from typing import Any

LATER = 10

_gave_way = False  # in this process, which cannot take it back


def give_way() -> None:
    """From now on this process leaves the processors to uploads."""
    global _gave_way
    if not _gave_way:
        _gave_way = True
        os.nice(LATER)


def giving_way(function: Callable[..., Any], *given: Any) -> Any:
    """What the function gives, in a process that gives way."""
    give_way()
    return function(*given)
