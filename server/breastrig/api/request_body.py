"""Bodies on their way in: received without a thread, kept in a bounded place, given up when too slow.

What is in memory or in the folder for temporary files at once is bounded in all (`--spool-mb`), and a client may hold
half of it, so that one who sends slowly cannot keep the others from sending.
"""

import asyncio
import logging
import tempfile
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import IO, Any

log = logging.getLogger(__name__)

Receive = Callable[[], Awaitable[Any]]


@dataclass(frozen=True)
class BodyLimits:
    total_bytes: int = 1_300_000_000  # three of the largest scans; each lies in the temporary folder up to twice
    memory_bytes: int = 65_536  # of one body; longer ones go to a file without a name
    pause_s: float = 30.0  # nothing at all for so long: the sender has gone
    grace_s: float = 30.0  # for any body, and beyond that:
    slowest_bytes_s: int = 10_000  # a bad mobile line has five times that
    unwanted_s: float = 30.0  # a body that was refused is still taken, and dropped: a reset could overtake the answer
    unwanted_pause_s: float = 5.0  # and when nothing comes for so long, the answer has been read


class BodyRefused(Exception):
    """The body is not taken; `status` and the sentence say why."""

    def __init__(self, status: int, sentence: str, retry_s: int | None = None) -> None:
        super().__init__(sentence)
        self.status = status
        self.sentence = sentence
        self.headers = {} if retry_s is None else {"Retry-After": str(retry_s)}


class SenderGone(Exception):
    """The connection ended before the body did."""


FULL = "The service's folder for temporary files is full; nothing was kept. Free space there, and try again."


@contextmanager
def _as_refusal() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        log.error("the folder for temporary files cannot take a request's body: %s", error.strerror)
        raise BodyRefused(507, FULL) from error


class Spool:
    """One body that was received, to be read from its start and closed."""

    def __init__(self, place: "SpoolPlace", client: str) -> None:
        self.size = 0
        self.file: IO[bytes]
        self._place = place
        self._client = client
        self._reserved = 0
        with _as_refusal():
            self.file = tempfile.SpooledTemporaryFile(place.limits.memory_bytes)  # noqa: SIM115  close() closes it

    def reserve(self, size: int) -> None:
        """Makes sure that the body may become so long."""
        if size > self._reserved:
            self._place.take(self._client, size - self._reserved)
            self._reserved = size

    def write(self, data: bytes) -> None:
        self.reserve(self.size + len(data))
        with _as_refusal():
            self.file.write(data)
        self.size += len(data)

    def rewind(self) -> None:
        with _as_refusal():
            self.file.seek(0)

    def close(self) -> None:
        """Gives the room back; a second call does nothing."""
        self._place.give_back(self._client, self._reserved)
        self._reserved = 0
        with suppress(OSError):  # what could not be written is not needed any more
            self.file.close()


class SpoolPlace:
    """The room for all bodies together, and in it at least for one of the `largest`.  Lives in the loop's thread."""

    def __init__(self, limits: BodyLimits, largest: int) -> None:
        self.limits = limits
        self._each_client = max(limits.total_bytes // 2, largest)
        self._all_clients = max(limits.total_bytes, largest)
        self._held: Counter[str] = Counter()  # bytes by client

    @property
    def held(self) -> int:
        return self._held.total()

    def take(self, client: str, size: int) -> None:
        """Raises BodyRefused when there is not so much room."""
        if self._held[client] + size > self._each_client:
            raise BodyRefused(429, "You are sending as much at once as one client may; try again in a few seconds.", 5)
        if self.held + size > self._all_clients:
            raise BodyRefused(503, "The service is receiving as much as it can; try again in a few seconds.", 5)
        self._held[client] += size

    def give_back(self, client: str, size: int) -> None:
        self._held[client] -= size
        if self._held[client] <= 0:
            del self._held[client]

    async def receive(self, receive: Receive, client: str, announced: int | None, most: int) -> Spool:
        """The whole body.  Raises BodyRefused, or SenderGone."""
        spool = Spool(self, client)
        try:
            spool.reserve(announced or 0)
            clock = asyncio.get_running_loop().time
            began = clock()
            while True:
                ends = began + self.limits.grace_s + spool.size / self.limits.slowest_bytes_s
                try:
                    message = await asyncio.wait_for(receive(), min(self.limits.pause_s, ends - clock()))
                except TimeoutError:
                    raise BodyRefused(408, "The request's body came too slowly; try again on a better line.") from None
                if message["type"] == "http.disconnect":
                    raise SenderGone
                data = message.get("body", b"")
                if spool.size + len(data) > most:
                    raise BodyRefused(413, too_large(most))
                spool.write(data)
                if not message.get("more_body", False):
                    spool.rewind()
                    return spool
        except BaseException:
            spool.close()
            raise

    async def drop(self, receive: Receive) -> None:
        """Takes what is still being sent of a body that was refused, for a while."""
        with suppress(TimeoutError):
            async with asyncio.timeout(self.limits.unwanted_s):
                while True:
                    message = await asyncio.wait_for(receive(), self.limits.unwanted_pause_s)
                    if not message.get("more_body", False):  # nor is there any more when the sender has gone
                        return


def too_large(most: int) -> str:
    """The sentence for a body of more than so many bytes."""
    shown = f"{most // 1_000_000} MB" if most >= 1_000_000 else f"{most // 1000} kB"
    return f"The request is larger than {shown}."
