"""Shared results: the first caller makes one, others who ask meanwhile get its result or its error.

The last results stay in memory, never on the disk: they come from several scans, and are dropped when one of them is
deleted. Those who wait each hold a thread of the caller, so their number is limited.
"""

import threading
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from typing import Generic, TypeVar

from breastrig.core.errors import TooMany
from breastrig.core.lru_cache import LruCache

Result = TypeVar("Result")

MOST_WAITING = 8  # of one result
RETRY_S = 3  # what is made here takes some seconds


class _Shared(Future[Result]):
    """A result, made or being made, with the number of those who wait."""

    waiting = 0


class Remembered(Generic[Result]):
    """Results by key.  May be called from any thread."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept: LruCache[Hashable, _Shared[Result]] = LruCache(most)
        self._lock = threading.Lock()

    def result(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """The result of `make`, or its exception. Raises TooMany when as many as may already wait for it."""
        with self._lock:
            kept = self._kept  # another one when `forget` is called meanwhile
            known = kept.get(key)
            if known is None:
                kept.put(key, mine := _Shared[Result]())
            elif known.waiting < MOST_WAITING or known.done():
                known.waiting += 1
            else:
                raise TooMany(f"This is being made for others already; ask again in {RETRY_S} s.", RETRY_S)
        if known is not None:
            return known.result()
        try:
            mine.set_result(make())
        except BaseException as error:
            with self._lock:
                kept.drop(key)
            mine.set_exception(error)
        return mine.result()

    def forget(self) -> None:
        """Drops all results, also those being made: a scan is deleted."""
        with self._lock:
            self._kept = LruCache(self._most)
