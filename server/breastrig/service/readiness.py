"""Whether new work would be done, for those who monitor the service, so it must cost little.

The answer is cached for a moment, because anybody may ask, as often as they like.
"""

import sqlite3
import threading
import time

from breastrig.execution.executor import Executor
from breastrig.storage.storage import Storage

KEPT_S = 2.0
WAIT_S = 5.0  # a new process is there within a second, and the longest transaction takes milliseconds


class Readiness:
    """Looks at the index, the data folder and at the pools of processes."""

    def __init__(self, storage: Storage, pools: dict[str, Executor]) -> None:
        self._storage = storage
        self._pools = pools  # name for people -> pool
        self._lock = threading.Lock()
        self._found: tuple[str, ...] = ()
        self._looked_at = -KEPT_S

    def troubles(self) -> tuple[str, ...]:
        """The present faults, one sentence each; empty when there is none."""
        with self._lock:
            if time.monotonic() - self._looked_at >= KEPT_S:
                self._found = tuple(self._look())
                self._looked_at = time.monotonic()
            return self._found

    def _look(self) -> list[str]:
        found = []
        if not (self._writes() or self._writes()):  # who first writes into a damaged file makes it again
            found.append("The index cannot be written.")
        if not self._storage.has_files():
            found.append("The files cannot be reached.")
        elif not self._storage.has_room():
            found.append("The data folder cannot be written.")
        found += [
            f"The processes that {name} do not answer." for name, pool in self._pools.items() if not pool.answer(WAIT_S)
        ]
        return found

    def _writes(self) -> bool:
        try:
            with self._storage.index.writing() as rows:
                rows.execute("DELETE FROM meta WHERE key = 'asked'")
        except (sqlite3.Error, OSError):
            return False
        return True
