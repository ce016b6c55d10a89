"""A few answers kept in memory and never on the disk: they come from several scans, and go when one of them goes."""

import threading
from collections import OrderedDict
from collections.abc import Hashable


class Remembered:
    """The last so many answers.  May be called from any thread."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept: OrderedDict[Hashable, bytes] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> bytes | None:
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)

    def put(self, key: Hashable, content: bytes) -> None:
        with self._lock:
            self._kept[key] = content
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)

    def forget(self) -> None:
        """A scan is deleted: nothing is remembered any more."""
        with self._lock:
            self._kept.clear()
