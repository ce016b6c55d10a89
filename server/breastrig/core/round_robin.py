"""A queue that is fair between clients: each in turn gives its oldest item, however many another has waiting.

Not safe between threads; whoever shares one holds a lock.
"""

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")


class RoundRobin(Generic[Item]):
    """Items by client; a client is any name."""

    def __init__(self) -> None:
        self._queues: dict[str, deque[Item]] = {}  # in the order of whose turn is next

    def __len__(self) -> int:
        return sum(map(len, self._queues.values()))

    def waiting(self, client: str) -> int:
        """How many items that client has."""
        return len(self._queues.get(client, ()))

    def has(self, may: Callable[[str], bool]) -> bool:
        """Whether a client that `may` has an item."""
        return any(may(client) for client in self._queues)

    def put(self, client: str, item: Item) -> None:
        self._queues.setdefault(client, deque()).append(item)

    def take(self, may: Callable[[str], bool] = lambda _client: True) -> tuple[str, Item] | None:
        """(client, its oldest item) of the next client that `may`; None when there is none."""
        for client in self._queues:
            if may(client):
                queue = self._queues.pop(client)
                item = queue.popleft()
                if queue:
                    self._queues[client] = queue  # at the end of the row
                return client, item
        return None

    def discard(self, client: str, item: Item) -> bool:
        """Takes an item out of its place; False when it is not there any more."""
        queue = self._queues.get(client)
        if queue is None or item not in queue:
            return False
        queue.remove(item)
        if not queue:
            del self._queues[client]
        return True
