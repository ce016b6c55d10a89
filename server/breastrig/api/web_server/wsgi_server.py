"""The web server: uvicorn's connections and event loop, threads only for what works.  One process, as the service's
queue and pools live in it.

Chosen by trial (uvicorn 0.54, waitress 3.0, gunicorn 27, granian 2.8, cheroot 11.1; two shared cores; 80 threads).
Four clients at work beside 24 open streams of events; requests answered in 6 s (95 % of them within ms):

                            undisturbed   2,000 idle   300 slow heads   300 slow bodies   300 slow readers
    waitress, as it was       1074 (36)            0                0                 0                  0
    waitress, poll, no cap    1330 (17)    270 (220)         698 (97)         1280 (29)       188 (times out)
    gunicorn gthread           1870 (5)     1984 (4)                0                 0                  0
    granian                    1800 (8)     1900 (5)         1720 (7)                 0                  0
    cheroot                    2000 (4)     drops most              0                 0                  0
    uvicorn + a2wsgi          1522 (10)    1456 (15)        1514 (11)                 0                  0
    this (*)                   860 (66)     534 (71)         870 (43)          868 (60)          582 (70)

(*) Another run, on a busier machine (load average 12 to 15): compare its columns, not its row with others.
Waitress, as it was, then answered 1532 (11) undisturbed, and again nothing in the other four.

None has it all.  gunicorn and granian run the application in processes of their own, none of them asks the
application before it takes a body, and only waitress and uvicorn let us say what a broken request is answered.
uvicorn is pure Python, so it runs wherever this does, on epoll or kqueue; what it lacks are three short modules:
connections.py (time limits and numbers of connections), request_body.py (bodies), wsgi_bridge.py (threads).
"""

import ctypes
import functools
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace

import uvicorn
from apiflask import APIFlask

from breastrig.api.config import Config
from breastrig.api.request_body import BodyLimits, SpoolPlace
from breastrig.api.trusted_proxy import BehindProxy
from breastrig.api.web_server.admission import Admission
from breastrig.api.web_server.connections import Connection, ConnectionLimits, Connections
from breastrig.api.web_server.wsgi_bridge import ThreadLimits, WsgiBridge
from breastrig.core.errors import BadSettings

ARENAS = 2  # of glibc's allocator; by default each thread has its own, and what one has held is never given back
M_ARENA_MAX = -8  # malloc.h
BACKLOG = 2048  # connections that the system holds until they are taken; most systems allow no more
STOP_S = 5  # a stopping server lets answers that are under way end for so long
OTHER_FILES = 512  # that the process opens besides connections: database, scans, temporary files, pipes


@dataclass(frozen=True)
class ServerLimits:
    connections: ConnectionLimits = field(default_factory=ConnectionLimits)
    bodies: BodyLimits = field(default_factory=BodyLimits)
    threads: ThreadLimits = field(default_factory=ThreadLimits)


class WsgiServer:
    """A server that is bound; `run()` accepts and serves until `stop()` is called."""

    def __init__(
        self,
        app: APIFlask,
        config: Config,
        listener: socket.socket,
        on_stop: Callable[[], None],
        limits: ServerLimits,
    ) -> None:
        proxy = config.trusted_proxy
        assert isinstance(app.wsgi_app, BehindProxy)
        self._listener = listener
        self.spools = SpoolPlace(limits.bodies, config.uploads.file_bytes)
        self._bridge = WsgiBridge(
            app.wsgi_app,
            Admission(app),
            app.wsgi_app,
            self.spools,
            limits.threads,
        )
        self.connections = Connections(limits.connections, lambda address: proxy is not None and proxy.is_at(address))
        self._server = _Uvicorn(
            uvicorn.Config(
                self._bridge,
                http=functools.partial(Connection, connections=self.connections),  # type: ignore[arg-type]
                ws="none",
                loop="asyncio",
                lifespan="off",
                interface="asgi3",
                workers=1,
                log_config=None,
                log_level="critical",  # broken requests can be sent by anybody; what breaks inside is logged by us
                access_log=False,
                proxy_headers=False,
                server_header=False,
                backlog=BACKLOG,
                timeout_keep_alive=limits.connections.idle_s,
                timeout_graceful_shutdown=STOP_S,
                h11_max_incomplete_event_size=limits.connections.head_bytes,
            ),
            on_stop,
        )

    @property
    def effective_port(self) -> int:
        return int(self._listener.getsockname()[1])

    def run(self) -> None:
        """Serves, in the main thread, until stopped; what is under way may end."""
        self._server.run(sockets=[self._listener])

    def stop(self) -> None:
        """May be called at any time, from any thread and from a signal handler."""
        self._server.should_exit = True

    def close(self) -> None:
        self._bridge.close()
        self._listener.close()


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


def listen(
    app: APIFlask,
    config: Config,
    port: int,
    on_stop: Callable[[], None],
    limits: ServerLimits | None = None,
) -> WsgiServer:
    """A server at the configuration's host.  Port 0 takes a free one.

    `on_stop` is called when it begins to stop, to end what would never end by itself.
    Raises BadSettings when the address cannot be had.
    """
    _share_arenas()
    asked = limits or ServerLimits(bodies=BodyLimits(total_bytes=config.spool_bytes))
    files = _as_many_files_as_allowed(asked.connections.total + OTHER_FILES)
    total = min(asked.connections.total, max(64, files - OTHER_FILES))
    used = replace(asked, connections=replace(asked.connections, total=total))
    return WsgiServer(app, config, _bound_socket(config.host, port), on_stop, used)


def _as_many_files_as_allowed(wanted: int) -> int:
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


def _share_arenas() -> None:
    """Before the threads start.  Without it the server grows by a hundred megabytes while it sends files of four."""
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, ARENAS)


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
