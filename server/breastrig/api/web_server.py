"""The web server: uvicorn, with a2wsgi's threads around the Flask application, in one process with queue and pools.

What a public server needs beyond this (slow clients by the hundred, TLS) belongs to the proxy in front of it:
docs/how-to/own_server.md has its configuration.  Of its own it bounds connections, idle time, silent senders and
readers, and what one client may have in work; Flask bounds bodies.
"""

import asyncio
import logging
import socket
import threading
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, cast

import h11
import uvicorn
from a2wsgi import WSGIMiddleware
from flask import Response
from uvicorn.protocols.http.h11_impl import H11Protocol

from breastrig.api.access.security import HEADERS
from breastrig.api.config import Config
from breastrig.api.errors import SENTENCES, problem
from breastrig.api.trusted_proxy import TrustedProxy, client_of
from breastrig.core.errors import BadSettings

BACKLOG = 2048  # connections that the system holds until they are taken
STOP_S = 5  # a stopping server lets answers end for so long
OTHER_FILES = 512  # that the process opens besides connections: database, scans, temporary files, pipes
GONE = "breastrig.gone"  # in the ASGI scope: a threading.Event, set when the connection has ended

log = logging.getLogger(__name__)

Scope = dict[str, Any]
Receive = Callable[[], Awaitable[dict[str, Any]]]
Send = Callable[[dict[str, Any]], Awaitable[None]]
Wsgi = Callable[[dict[str, Any], Any], Iterable[bytes]]


@dataclass(frozen=True)
class ServerLimits:
    connections: int = 8000  # 20 kB each; fewer where the system allows fewer files
    idle_s: int = 75  # between two requests, and for a request's head; reverse proxies keep theirs for 60
    silent_s: float = 60.0  # a body of which nothing comes, an answer of which nothing is taken
    head_bytes: int = 32_768  # twice what browsers send with all their cookies
    threads: int = 160  # requests in work: as many event streams as are allowed, and as many others again
    threads_each: int = 80  # of one client


class Server:
    """A server that is bound; `run()` accepts and serves until `stop()` is called."""

    def __init__(self, app: Wsgi, config: Config, port: int, on_stop: Callable[[], None], limits: ServerLimits) -> None:
        """Port 0 takes a free one.  Raises BadSettings when the address cannot be had."""
        files = _raise_file_limit(limits.connections + OTHER_FILES)
        self._listener = _bound_socket(config.host, port)
        self._bounded = _Bounded(app, config.trusted_proxy, limits)
        self._server = _Uvicorn(
            uvicorn.Config(
                self._bounded,
                http=_Connection,
                ws="none",
                loop="asyncio",
                lifespan="off",
                interface="asgi3",
                log_config=None,
                log_level="critical",  # anybody can send broken requests; the application logs its own errors
                access_log=False,
                proxy_headers=False,  # trusted_proxy.py does it
                server_header=False,
                backlog=BACKLOG,
                limit_concurrency=min(limits.connections, max(64, files - OTHER_FILES)),
                timeout_keep_alive=limits.idle_s,
                timeout_graceful_shutdown=STOP_S,
                h11_max_incomplete_event_size=limits.head_bytes,
            ),
            on_stop,
        )

    @property
    def effective_port(self) -> int:
        return int(self._listener.getsockname()[1])

    def run(self) -> None:
        """Serves, in this thread, until stopped; what is under way may end."""
        self._server.run(sockets=[self._listener])

    def stop(self) -> None:
        """Stops the server; may be called from any thread, and from a signal handler."""
        self._server.should_exit = True

    def close(self) -> None:
        self._bounded.close()
        self._listener.close()


class _Bounded:
    """The application as ASGI: time limits on silent clients, and a share of the threads for each."""

    def __init__(self, app: Wsgi, proxy: TrustedProxy | None, limits: ServerLimits) -> None:
        self._asgi: Any = WSGIMiddleware(cast(Any, app), workers=limits.threads)
        self._proxy, self._limits = proxy, limits
        self._in_work: Counter[str] = Counter()

    def close(self) -> None:
        """Threads that still work end by themselves."""
        self._asgi.executor.shutdown(wait=False, cancel_futures=True)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        address = scope["client"][0] if scope["client"] else ""
        client = client_of(address)
        many = self._proxy is not None and self._proxy.is_at(address)  # one address, many clients
        if self._in_work[client] >= self._limits.threads_each and not many:
            await _refuse(send)
            return
        self._in_work[client] += 1
        exchange = _Exchange(scope, receive, send, self._limits.silent_s)
        try:
            await self._asgi(exchange.scope, exchange.receive, exchange.send)
        except ConnectionError:  # the application ended the answer on purpose
            pass
        except Exception as error:  # in the middle of an answer; all others are the application's own
            log.error("an answer broke off: %s", type(error).__name__)
        finally:
            exchange.end()
            self._in_work -= Counter({client: 1})


class _Exchange:
    """One request and its answer."""

    def __init__(self, scope: Scope, receive: Receive, send: Send, silent_s: float) -> None:
        names = [(name, value) for name, value in scope["headers"] if b"_" not in name]  # X_Forwarded_For is not X-...
        self.gone = threading.Event()
        self.scope = scope | {"headers": names, GONE: self.gone}
        self._receive, self._send, self._silent_s = receive, send, silent_s
        self._unread = False  # the reader has taken nothing for too long
        self._watch: asyncio.Task[None] | None = None
        if not {name for name, _ in names} & {b"content-length", b"transfer-encoding"}:
            self._watch = asyncio.create_task(self._until_gone())

    async def receive(self) -> dict[str, Any]:
        """The next part of the body; a sender who is silent for too long has gone."""
        if self._watch is not None:
            return {"type": "http.request", "body": b"", "more_body": False}
        try:
            message = await asyncio.wait_for(self._receive(), self._silent_s)
        except TimeoutError:
            message = {"type": "http.disconnect"}
        if message["type"] == "http.disconnect":
            self.gone.set()
        elif not message.get("more_body", False):
            self._watch = asyncio.create_task(self._until_gone())
        return message

    async def send(self, message: dict[str, Any]) -> None:
        """Sends a part of the answer; nothing more to a reader who takes nothing for too long."""
        if self._unread:
            return
        try:
            await asyncio.wait_for(self._send(message), self._silent_s)
        except TimeoutError:
            self._unread = True
            self.gone.set()

    def end(self) -> None:
        self.gone.set()
        if self._watch is not None:
            self._watch.cancel()

    async def _until_gone(self) -> None:
        while (await self._receive())["type"] != "http.disconnect":
            pass
        self.gone.set()


class _Connection(H11Protocol):
    """uvicorn's, whose time limit between two requests holds for the first request and for its head as well."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        super().connection_made(transport)
        self._limit_idle()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if (self.cycle is None or self.cycle.response_complete) and not self.transport.is_closing():
            self._limit_idle()

    def send_400_response(self, msg: str) -> None:
        """uvicorn calls it for what is no HTTP."""
        answer = problem(400, SENTENCES[400], headers=HEADERS | {"Connection": "close"})
        events = (h11.Response(status_code=400, headers=_raw(answer)), h11.Data(answer.get_data()), h11.EndOfMessage())
        for event in events:
            self.transport.write(self.conn.send(event) or b"")
        self.transport.close()

    def _limit_idle(self) -> None:
        self._unset_keepalive_if_required()
        handler = self.timeout_keep_alive_handler
        self.timeout_keep_alive_task = self.loop.call_later(self.timeout_keep_alive, handler)

    def connection_lost(self, exc: Exception | None) -> None:
        self._unset_keepalive_if_required()
        super().connection_lost(exc)


class _Uvicorn(uvicorn.Server):
    def __init__(self, config: uvicorn.Config, on_stop: Callable[[], None]) -> None:
        super().__init__(config)
        self._on_stop = on_stop

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._on_stop()
        await super().shutdown(sockets)

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Signals are the program's own business."""
        yield


def _raw(answer: Response) -> list[tuple[bytes, bytes]]:
    return [(name.lower().encode(), value.encode()) for name, value in answer.headers.items()]


async def _refuse(send: Send) -> None:
    answer = problem(
        429, "You have as many requests in work as one client may; wait for their answers.", headers=HEADERS
    )
    await send({"type": "http.response.start", "status": 429, "headers": _raw(answer)})
    await send({"type": "http.response.body", "body": answer.get_data()})


def _raise_file_limit(wanted: int) -> int:
    """Raises the soft limit of open files, which is 1,024 or 256 on many systems; what it is now."""
    try:
        import resource
    except ImportError:  # Windows counts otherwise
        return wanted
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    for more in (wanted, 10_240):  # macOS says "unlimited" and means the second
        allowed = more if hard == resource.RLIM_INFINITY else min(more, hard)
        if soft == resource.RLIM_INFINITY or soft >= allowed:
            break
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (allowed, hard))
            break
    soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return wanted if soft == resource.RLIM_INFINITY else soft


def _bound_socket(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, kind, protocol)
    except (OSError, UnicodeError) as error:
        raise BadSettings(f'"{host}" is not an address of this machine; use 127.0.0.1.') from error
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(BACKLOG)  # whoever asks before the service is ready waits
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise BadSettings(f"Port {port} of {host} cannot be used ({reason}); choose another with --port.") from error
    return listener
