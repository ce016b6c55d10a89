"""Waitress around the application: one process, many threads, since every open event stream holds one.

Waitress answers broken requests itself, in plain text; here they become problem details with the same security
headers as everything else.
"""

import ctypes
import socket
from contextlib import suppress
from typing import Any

from waitress.channel import HTTPChannel
from waitress.server import BaseWSGIServer, create_server
from waitress.task import ErrorTask

from breastrig.api.config import STREAMS
from breastrig.api.errors import SENTENCES, problem
from breastrig.api.security import HEADERS
from breastrig.core.errors import BadSettings

THREADS = STREAMS + 16  # 16 for everything else: what takes long is done by processes, two or four at a time
ARENAS = 2  # of glibc's allocator; by default each thread has its own, and what one has held is never given back
M_ARENA_MAX = -8  # malloc.h
SPARE_BYTES = 10_000_000  # over the upload limit: a body in between is refused by us, with a better sentence


class _ProblemTask(ErrorTask):  # type: ignore[misc]
    """A request that the application never saw."""

    def execute(self) -> None:
        error = self.request.error
        sentence = SENTENCES.get(error.code, "The request cannot be understood.")
        answer = problem(error.code, sentence, headers=HEADERS)
        body = answer.get_data()
        self.status = f"{error.code} {error.reason}"
        for name, value in answer.headers.items():
            self.response_headers.append((name, value))
        self.set_close_on_finish()
        self.content_length = len(body)
        self.write(body)


class _Channel(HTTPChannel):  # type: ignore[misc]
    error_task_class = _ProblemTask


def listen(app: Any, host: str, port: int, upload_bytes: int) -> Any:
    """A server that is bound and accepts; `run()` serves until SystemExit.  Port 0 takes a free one.

    Raises BadSettings when the address cannot be had.
    """
    _share_arenas()
    listener = _bound_socket(host, port)
    server = create_server(
        app,
        sockets=[listener],
        threads=THREADS,
        max_request_body_size=upload_bytes + SPARE_BYTES,
        channel_request_lookahead=1,  # lets a stream notice that its viewer has left
        ident="BreastRig",
        clear_untrusted_proxy_headers=True,
    )
    assert isinstance(server, BaseWSGIServer)
    server.channel_class = _Channel
    return server


def _share_arenas() -> None:
    """Before the threads start.  Without it the server grows by a hundred megabytes while it sends files of four."""
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, ARENAS)


def _bound_socket(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, kind, protocol)
    except OSError as error:
        raise BadSettings(f'"{host}" is not an address of this machine; use 127.0.0.1.') from error
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise BadSettings(f"Port {port} of {host} cannot be used ({reason}); choose another with --port.") from error
    return listener
