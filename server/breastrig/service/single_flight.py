"""Work that many ask for at once and that is done once: the first does it, the others get its result or its error.

Those who wait each hold a thread of the caller, so there is a limit to them.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Generic, TypeVar

from breastrig.core.errors import TooMany

Result = TypeVar("Result")

MOST_WAITING = 8  # of one result
RETRY_S = 3  # what is made here takes some seconds


class SingleFlight(Generic[Result]):
    """The results that are being made, by key."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._made: dict[str, Future[Result]] = {}
        self._waiting: dict[str, int] = {}

    def result(self, key: str, make: Callable[[], Result]) -> Result:
        """What `make` gives, or raises.  Raises TooMany when as many as may already wait for it."""
        with self._lock:
            future = self._made.get(key)
            if future is None:
                mine = self._made[key] = Future()
                self._waiting[key] = 0
            elif self._waiting[key] >= MOST_WAITING:
                raise TooMany(f"This is being made for others already; ask again in {RETRY_S} s.", RETRY_S)
            else:
                self._waiting[key] += 1
        if future is not None:
            return future.result()
        try:
            made = make()
        except BaseException as error:
            mine.set_exception(error)
            raise
        else:
            mine.set_result(made)
            return made
        finally:
            with self._lock:
                del self._made[key], self._waiting[key]
