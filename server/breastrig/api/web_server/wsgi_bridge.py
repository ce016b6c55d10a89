"""The WSGI application as an ASGI one: threads only for what really works, and fairly between clients.

    headers -> admitted? (thread) -> body into the spool (no thread) -> application (thread) -> answer (no thread)

Whoever sends or reads slowly holds no thread: bodies are complete before the application sees them, and of an answer
a thread fetches the next piece only when the last one has gone out.  A stream of events waits in no thread either: it
says at once when it has nothing (an empty piece, as WSGI allows), and wakes us when it has.  Requests of one client
are not all worked on at once, and waiting ones are taken in turns, one of each client.
"""

import asyncio
import io
import logging
import sys
import threading
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from urllib.parse import unquote_to_bytes, urlsplit

from breastrig.api.access.security import HEADERS
from breastrig.api.environ_keys import READER_GONE, WAKE
from breastrig.api.errors import SENTENCES, problem
from breastrig.api.request_body import BodyRefused, Receive, SenderGone, Spool, SpoolPlace
from breastrig.api.trusted_proxy import BehindProxy, client_of
from breastrig.api.web_server.admission import Admission
from breastrig.core.round_robin import RoundRobin

PIECE = 65_536  # bytes of an answer that are fetched at once at first, and that are handed over at once
LARGEST_PIECE = 4 * PIECE  # of a reader who keeps pace; so much of each answer may lie in memory
SILENT_S = 0.5  # after which a stream that has nothing is asked whether it has to beat
KEEPS_PACE_S = 0.02  # in which a piece has gone out: each fetch waits for its client's turn and changes threads twice

Send = Callable[[dict[str, Any]], Awaitable[None]]
Wsgi = Callable[[dict[str, Any], Any], Iterable[bytes]]

BROKEN = problem(500, SENTENCES[500], headers=HEADERS)

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ThreadLimits:
    work: int = 64  # most of them wait for a process or for the database
    each_client: int = 12  # a browser asks for six things at once


@dataclass
class _Answer:
    """What the application answers, as far as it has come."""

    status: int
    headers: list[tuple[bytes, bytes]]
    rest: Iterator[bytes]
    close: Callable[[], None]
    first: bytes = b""
    complete: bool = False
    at_once: int = PIECE  # bytes to be fetched next

    @cached_property
    def streams(self) -> bool:
        return any(name == b"content-type" and value.startswith(b"text/event-stream") for name, value in self.headers)


class WsgiBridge:
    """ASGI around a WSGI application and its admission."""

    def __init__(
        self, app: Wsgi, admission: Admission, proxy: BehindProxy, spools: SpoolPlace, threads: ThreadLimits
    ) -> None:
        self._app = app
        self._admission = admission
        self._proxy = proxy
        self._spools = spools
        self._turns = _Turns(threads.work, threads.each_client)
        self._work = ThreadPoolExecutor(threads.work, "breastrig-work")

    def close(self) -> None:
        """Leaves threads that still work to end by themselves."""
        self._work.shutdown(wait=False, cancel_futures=True)

    async def __call__(self, scope: dict[str, Any], receive: Receive, send: Send) -> None:
        answers = _Answers(send)
        try:
            await self._answer(_environ(scope), receive, answers)
        except SenderGone:
            pass
        except Exception as error:
            if not isinstance(error, ConnectionError):  # that one says itself that a reader was sent away
                log.error("an answer broke off: %s", type(error).__name__)
            if not answers.begun:
                await answers.begin(500, [(name.lower().encode(), value.encode()) for name, value in BROKEN.headers])
                await answers.piece(BROKEN.get_data(), last=True)

    async def _answer(self, environ: dict[str, Any], receive: Receive, answers: "_Answers") -> None:
        self._proxy.take_over(environ)
        client = client_of(environ["REMOTE_ADDR"])
        news = _News(asyncio.get_running_loop())
        environ[READER_GONE] = news.gone.is_set
        environ[WAKE] = news.wake
        spool: Spool | None = None
        watch: asyncio.Task[None] | None = None
        try:
            if _has_body(environ):
                spool, refusal = await self._body(environ, client, receive)
                if refusal is not None:
                    await answers.begin(refusal.status, refusal.headers)
                    await answers.piece(refusal.first)
                    if "HTTP_EXPECT" not in environ:
                        await self._spools.drop(receive)
                    await answers.piece(b"", last=True)
                    return
            watch = asyncio.create_task(_watch(receive, news))
            if spool is not None:
                environ |= {"wsgi.input": spool.file, "CONTENT_LENGTH": str(spool.size)}
                environ.pop("HTTP_TRANSFER_ENCODING", None)
            await self._send(await self._in_turn(client, _begin, self._app, environ), client, news, answers)
        finally:
            if watch is not None:
                watch.cancel()
            if spool is not None:
                spool.close()

    async def _body(
        self, environ: dict[str, Any], client: str, receive: Receive
    ) -> tuple[Spool | None, _Answer | None]:
        """The body, or the answer to a request that may not send it.  Raises SenderGone."""
        verdict = await self._in_turn(client, self._admission.check, environ)
        if isinstance(verdict, int):
            announced = int(environ["CONTENT_LENGTH"]) if environ.get("CONTENT_LENGTH") else None
            try:
                return await self._spools.receive(receive, client, announced, verdict), None
            except BodyRefused as error:
                verdict = await self._in_turn(
                    client, self._admission.refuse, environ, error.status, error.sentence, error.headers
                )
        return None, await self._in_turn(client, _begin, verdict, environ)

    async def _send(self, answer: _Answer, client: str, news: "_News", answers: "_Answers") -> None:
        """Sends it piece by piece, as fast as the reader takes it."""
        try:
            await answers.begin(answer.status, answer.headers)
            piece = answer.first
            while not answer.complete and not news.gone.is_set():
                began = time.monotonic()
                await answers.piece(piece)
                if time.monotonic() - began < KEEPS_PACE_S:
                    answer.at_once = min(2 * answer.at_once, LARGEST_PIECE)
                piece = await (self._next(answer, client) if not answer.streams else _next_of_stream(answer, news))
            await answers.piece(piece, last=True)
        finally:
            if not answer.complete:
                with suppress(RuntimeError):  # the pool is closed, the server is stopping
                    self._work.submit(_give_up, answer)

    async def _next(self, answer: _Answer, client: str) -> bytes:
        piece: bytes = await self._in_turn(client, _fetch, answer)
        return piece

    async def _in_turn(self, client: str, function: Callable[..., Any], *args: Any) -> Any:
        """Runs it in a thread when it is that client's turn."""
        async with self._turns.turn(client):
            return await asyncio.get_running_loop().run_in_executor(self._work, function, *args)


class _Answers:
    """What is sent on one request."""

    def __init__(self, send: Send) -> None:
        self.begun = False
        self._send = send

    async def begin(self, status: int, headers: list[tuple[bytes, bytes]]) -> None:
        self.begun = True
        await self._send({"type": "http.response.start", "status": status, "headers": headers})

    async def piece(self, content: bytes, last: bool = False) -> None:
        """Waits while the reader has not taken the pieces before."""
        for start in range(0, len(content), PIECE) if content else (0,) if last else ():
            part = content[start : start + PIECE]
            ends = last and start + PIECE >= len(content)
            await self._send({"type": "http.response.body", "body": part, "more_body": not ends})


class _Turns:
    """So many at once in all, so many of one client."""

    def __init__(self, most: int, each_client: int) -> None:
        self._most = most
        self._each_client = each_client
        self._running: Counter[str] = Counter()
        self._waiting: RoundRobin[asyncio.Future[None]] = RoundRobin()

    @asynccontextmanager
    async def turn(self, client: str) -> AsyncIterator[None]:
        """Waits until it is the client's turn."""
        mine = asyncio.get_running_loop().create_future()
        self._waiting.put(client, mine)
        self._let_in()
        try:
            await mine
        except asyncio.CancelledError:
            if not self._waiting.discard(client, mine):  # it was let in at the same moment
                self._leave(client)
            raise
        try:
            yield
        finally:
            self._leave(client)

    def _leave(self, client: str) -> None:
        self._running[client] -= 1
        if not self._running[client]:
            del self._running[client]
        self._let_in()

    def _let_in(self) -> None:
        while self._running.total() < self._most:
            taken = self._waiting.take(lambda client: self._running[client] < self._each_client)
            if taken is None:
                return
            self._running[taken[0]] += 1
            if not taken[1].done():
                taken[1].set_result(None)


class _News:
    """That a stream has something to say, or that nobody reads it any more."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.gone = threading.Event()
        self._loop = loop
        self._heard = asyncio.Event()

    def wake(self) -> None:
        """In any thread."""
        with suppress(RuntimeError):  # the server has stopped
            self._loop.call_soon_threadsafe(self._heard.set)

    def leave(self) -> None:
        """In the event loop: the reader has gone."""
        self.gone.set()
        self._heard.set()

    def reset(self) -> None:
        """News from here on end the next `wait`."""
        self._heard.clear()

    async def wait(self, timeout_s: float) -> None:
        """Returns when there were news since `reset`, at the latest after `timeout_s`."""
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                await self._heard.wait()


async def _watch(receive: Receive, news: _News) -> None:
    """Notes when the connection has ended."""
    while (await receive())["type"] != "http.disconnect":
        pass
    news.leave()


async def _next_of_stream(answer: _Answer, news: _News) -> bytes:
    """Waits for the next piece that is not empty; b"" when there is none."""
    while True:
        news.reset()
        if (piece := _fetch_one(answer)) or answer.complete:
            return piece
        await news.wait(SILENT_S)
        if news.gone.is_set():
            return b""


def _begin(app: Wsgi, environ: dict[str, Any]) -> _Answer:
    """In a thread: calls the application and fetches the first piece, which most often is all."""
    started: list[tuple[str, list[tuple[str, str]]]] = []

    def start_response(status: str, headers: list[tuple[str, str]], _exc_info: Any = None) -> None:
        started[:] = [(status, headers)]

    result = app(environ, start_response)
    status, headers = started[0]
    encoded = [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in headers]
    close = getattr(result, "close", lambda: None)
    answer = _Answer(int(status.split(" ", 1)[0]), encoded, iter(result), close)
    try:
        answer.first = _fetch_one(answer) if answer.streams else _fetch(answer)
    except BaseException:
        answer.close()
        raise
    return answer


def _fetch(answer: _Answer) -> bytes:
    """In a thread: the next piece, of `at_once` bytes or what the application gives at once; completes the answer."""
    parts, size = [], 0
    while size < answer.at_once:
        part = next(answer.rest, None)
        if part is None:
            _end(answer)
            break
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def _fetch_one(answer: _Answer) -> bytes:
    """The next piece as the application gives it, at once."""
    part = next(answer.rest, None)
    if part is None:
        _end(answer)
    return part or b""


def _end(answer: _Answer) -> None:
    answer.complete = True
    answer.close()


def _has_body(environ: dict[str, Any]) -> bool:
    return environ.get("CONTENT_LENGTH", "0") != "0" or "HTTP_TRANSFER_ENCODING" in environ


def _give_up(answer: _Answer) -> None:
    """In a thread: frees what an answer held that nobody reads to its end."""
    try:
        answer.close()
    except Exception as error:  # also a stream that is in the middle of its next event, when the server stops
        log.error("an answer could not be closed: %s", type(error).__name__)


def _environ(scope: dict[str, Any]) -> dict[str, Any]:
    """The WSGI environ of a request without a body."""
    path = scope["raw_path"]
    if not path.startswith(b"/"):
        path = urlsplit(path).path  # "GET http://HOST/PATH", as to a proxy
    environ: dict[str, Any] = {
        "REQUEST_METHOD": scope["method"],
        "SCRIPT_NAME": "",
        "PATH_INFO": unquote_to_bytes(path).decode("latin-1"),
        "QUERY_STRING": scope["query_string"].decode("latin-1"),
        "SERVER_PROTOCOL": f"HTTP/{scope['http_version']}",
        "SERVER_NAME": (scope["server"] or ("localhost", None))[0],
        "SERVER_PORT": str((scope["server"] or ("localhost", None))[1] or 0),
        "REMOTE_ADDR": (scope["client"] or ("",))[0],
        "wsgi.version": (1, 0),
        "wsgi.url_scheme": scope["scheme"],
        "wsgi.input": io.BytesIO(),
        "wsgi.input_terminated": True,
        "wsgi.errors": sys.stderr,
        "wsgi.multithread": True,
        "wsgi.multiprocess": False,
        "wsgi.run_once": False,
    }
    for name, value in scope["headers"]:
        if b"_" in name:  # would look like another header, X-Forwarded-For for one
            continue
        key = name.decode("latin-1").upper().replace("-", "_")
        key = key if key in ("CONTENT_TYPE", "CONTENT_LENGTH") else f"HTTP_{key}"
        text = value.decode("latin-1")
        environ[key] = text if key not in environ else f"{environ[key]}{'; ' if key == 'HTTP_COOKIE' else ','}{text}"
    return environ
