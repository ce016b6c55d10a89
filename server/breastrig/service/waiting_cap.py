"""How many fits one client may have waiting: nobody keeps the workers from everybody else.

Who asked for which fit is kept in this process's memory only, because an address says something about a person; after
a restart each client may fill its share anew.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from breastrig.core.errors import TooMany
from breastrig.storage.rows.fits import still_queued
from breastrig.storage.storage import Storage

RETRY_S = 2  # a fit takes about a second


class WaitingCap:
    """Counts each client's waiting fits; one fit of two stances counts once."""

    def __init__(self, storage: Storage, most: int) -> None:
        self._storage = storage
        self._most = most
        self._lock = threading.Lock()
        self._asked: dict[str, set[str]] = {}  # client -> its fits, those that no longer wait are dropped at times

    @contextmanager
    def place(self, client: str | None) -> Iterator[Callable[[str], None]]:
        """A place for one more fit; to be called with the fit's id.  Raises TooMany when the client has no place left.

        None is a caller inside the program, which is not counted.
        """
        if client is None:
            yield lambda _fit_id: None
            return
        with self._lock:
            waiting = still_queued(self._storage, self._asked.get(client, set()))
            if len(waiting) >= self._most:
                raise TooMany(
                    f"{len(waiting)} of your fits are waiting already, as many as one client may have; "
                    f"ask again in {RETRY_S} s.",
                    RETRY_S,
                )
            self._asked[client] = waiting
            self._asked = {name: fits for name, fits in self._asked.items() if fits or name == client}
            yield waiting.add
