"""Whether work that comes now would be done: asked by those who watch the service, so it must cost little.

The answer is kept for a moment, because anybody may ask, as often as they like.
"""

import threading
import time

from breastrig.execution.executor import Executor
from breastrig.storage.storage import Storage

KEPT_S = 2.0
CHECK_S = 0.1  # thirty megabytes of rows that the system has in memory; the hourly sweep looks at all
WAIT_S = 5.0  # a new process is there within a second, and the longest transaction takes milliseconds


class Readiness:
    """Looks at the database and at the pools of processes."""

    def __init__(self, storage: Storage, pools: dict[str, Executor]) -> None:
        self._storage = storage
        self._pools = pools  # name for people -> pool
        self._lock = threading.Lock()
        self._found: tuple[str, ...] = ()
        self._looked_at = -KEPT_S

    def troubles(self) -> tuple[str, ...]:
        """What is wrong, one sentence each; empty when all is well."""
        with self._lock:
            if time.monotonic() - self._looked_at >= KEPT_S:
                self._found = tuple(self._look())
                self._looked_at = time.monotonic()
            return self._found

    def _look(self) -> list[str]:
        found = []
        if self._storage.was_damaged or not self._storage.database.is_sound(CHECK_S):
            found.append("The database cannot be read; its file may be damaged or gone.")
        if not self._storage.database.can_write(WAIT_S):
            found.append("The database cannot be written.")
        if not self._storage.has_files():
            found.append("The files cannot be reached.")
        found += [
            f"The processes that {name} do not answer." for name, pool in self._pools.items() if not pool.answer(WAIT_S)
        ]
        return found
