"""How long a connection may keep the server waiting, and how many there may be.

uvicorn has no time limit for a request's head and for a reader that takes nothing, and limits requests, but not
connections.  `Connection` adds that to its HTTP/1.1 protocol.

A connection that waits for its client costs a file and about 20 kB, no thread.  When there are too many, of one
address or in all, the one that has waited longest is closed for the new one, first of the address that has most: HTTP
allows it, browsers just connect again, and whoever opens thousands only closes his own.
"""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from breastrig.api.access.security import HEADERS
from breastrig.api.errors import SENTENCES, problem

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ConnectionLimits:
    total: int = 8000  # 250 MB when all of them wait; fewer where the system allows fewer files
    each_address: int = 2500  # a house behind one address: four hundred browsers with six each
    head_s: float = 20.0  # from the first byte to the end of the headers; a bad mobile line needs two
    idle_s: int = 75  # between two requests; reverse proxies keep theirs for 60
    unread_s: float = 60.0  # a reader that takes less than 48 kB in this time has gone, or holds memory on purpose
    head_bytes: int = 32_768  # twice what browsers send with all their cookies


class Connections:
    """All that are open.  Lives in the event loop's thread."""

    def __init__(self, limits: ConnectionLimits, unlimited: Callable[[str], bool]) -> None:
        self.limits = limits
        self._unlimited = unlimited  # addresses that stand for many clients: the trusted proxy
        self._by_address: dict[str, dict[Connection, None]] = {}  # each in the order of their last requests
        self._total = 0

    def __len__(self) -> int:
        return self._total

    def add(self, connection: "Connection") -> bool:
        """Takes it in, if need be for another one; False when all are at work."""
        address = connection.address
        own = self._by_address.get(address, {})
        if len(own) >= self.limits.each_address and not self._unlimited(address):
            if not self._close_one_of(own):
                return False
        elif self._total >= self.limits.total:
            fullest = sorted(self._by_address.values(), key=len, reverse=True)[:10]
            if not any(map(self._close_one_of, fullest)):
                return False
        self._by_address.setdefault(address, {})[connection] = None
        self._total += 1
        return True

    def used(self, connection: "Connection") -> None:
        """Its turn to be closed comes last."""
        own = self._by_address.get(connection.address, {})
        if connection in own:
            del own[connection]
            own[connection] = None

    def remove(self, connection: "Connection") -> None:
        own = self._by_address.get(connection.address, {})
        if connection in own:
            del own[connection]
            self._total -= 1
            if not own:
                del self._by_address[connection.address]

    def _close_one_of(self, own: "dict[Connection, None]") -> bool:
        for connection in own:
            if connection.waits:
                self.remove(connection)
                connection.transport.abort()
                return True
        return False


class Connection(H11Protocol):
    """uvicorn's, with the limits above, and with problem details for what the application never sees."""

    def __init__(self, *args: Any, connections: Connections, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.address = ""
        self._all = connections
        self._head: asyncio.TimerHandle | None = None
        self._unread: asyncio.TimerHandle | None = None
        self._heard = False

    @property
    def waits(self) -> bool:
        """Whether no request is under way."""
        return self.cycle is None or self.cycle.response_complete

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.address = self.client[0] if self.client else ""
        if self._all.add(self):
            self._await_head()
        else:
            self._answer(503, "The service has as many connections as it can; try again in a few seconds.")

    def connection_lost(self, exc: Exception | None) -> None:
        self._all.remove(self)
        self._head_is_here()
        self._read_again()
        self._unset_keepalive_if_required()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if self.transport.is_closing():
            return
        self._heard = True
        super().data_received(data)
        if not self.waits:
            self._head_is_here()
        elif self._head is None:
            self._await_head()

    def on_response_complete(self) -> None:
        self._all.used(self)
        super().on_response_complete()
        if self.transport.is_closing():
            self._abort_if_unread()
        elif self.waits and self.conn.their_state is h11.SEND_BODY:  # a body that nobody wants, for long enough
            self.transport.close()
            self._abort_if_unread()

    def send_400_response(self, msg: str) -> None:
        """uvicorn calls it for what is no HTTP."""
        self._answer(400, SENTENCES[400])

    def timeout_keep_alive_handler(self) -> None:
        self._abort_if_unread()
        with suppress(h11.LocalProtocolError):
            super().timeout_keep_alive_handler()

    def shutdown(self) -> None:
        self._abort_if_unread()
        with suppress(h11.LocalProtocolError):
            super().shutdown()

    def pause_writing(self) -> None:
        super().pause_writing()
        if self._unread is None:
            self._unread = self.loop.call_later(self._all.limits.unread_s, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        self._read_again()

    def _answer(self, status: int, sentence: str) -> None:
        """Ends the connection with a problem of ours, when nothing else has been said yet."""
        if self.cycle is not None and not self.cycle.response_complete:  # what was under way has no reader any more
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE):
            self.transport.abort()
            return
        answer = problem(status, sentence, headers=HEADERS | {"Connection": "close"})
        headers = [(name.lower().encode(), value.encode()) for name, value in answer.headers.items()]
        events = (h11.Response(status_code=status, headers=headers), h11.Data(answer.get_data()), h11.EndOfMessage())
        for event in events:
            self.transport.write(self.conn.send(event) or b"")
        self.transport.close()
        self._abort_if_unread()

    def _head_too_slow(self) -> None:
        if self._heard:
            self._answer(408, "The request's headers took too long; send them at once.")
        else:
            self.transport.abort()

    def _await_head(self) -> None:
        self._head = self.loop.call_later(self._all.limits.head_s, self._head_too_slow)

    def _head_is_here(self) -> None:
        if self._head is not None:
            self._head.cancel()
            self._head = None

    def _read_again(self) -> None:
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None

    def _abort_if_unread(self) -> None:
        """A closed connection stays open until its last bytes are taken, which may be never."""
        if self.transport.get_write_buffer_size() and self._unread is None:
            self._unread = self.loop.call_later(self._all.limits.unread_s, self.transport.abort)
