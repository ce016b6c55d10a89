"""A process that keeps one thing at hand and answers calls about it: a fitted scan that is being worked on.

The pools (processes.py) end a process with its task, so that nothing of one patient is left for the next.  That holds
here too: a process has one thing from its start to its end, and is ended, never given another.  Like theirs it forks
from the fork server and has limits of memory; each call has a limit of time, and a process that keeps none is killed.

Questions and answers are bytes: nothing that a process sends is unpickled here.
"""

import multiprocessing
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, Protocol

from breastrig.core.errors import BreastRigError, FitFailed
from breastrig.execution.processes import limit_process

FAILED, ANSWERED = b"-", b"+"


class Answerer(Protocol):
    def __call__(self, question: bytes, /) -> bytes: ...


class WarmProcess:
    """`opener(*arguments)` makes in the process what answers; both must be picklable.  For one caller at a time."""

    def __init__(self, opener: Callable[..., Answerer], arguments: tuple[Any, ...], memory_bytes: int) -> None:
        context = multiprocessing.get_context("forkserver")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs, opener, arguments, memory_bytes), name="breastrig-warm", daemon=True
        )
        self._process.start()
        theirs.close()
        self._ended = threading.Event()

    @property
    def is_alive(self) -> bool:
        return not self._ended.is_set() and self._process.is_alive()

    def opened(self, wait_s: float) -> None:
        """Returns once the thing is at hand.  Raises as `answer`."""
        self._received(wait_s)

    def answer(self, question: bytes, wait_s: float) -> bytes:
        """Raises FitFailed with the process's sentence, TimeoutError, or another OSError when it has died.

        After an OSError it is ended.
        """
        try:
            self._connection.send_bytes(question)
        except OSError:
            self.end()
            raise
        return self._received(wait_s)

    def end(self) -> None:
        """Kills it, and returns when it is gone."""
        if not self._ended.is_set():
            self._ended.set()
            self._process.kill()
            self._process.join()  # the connection closes with its last user, who may be waiting in another thread

    def _received(self, wait_s: float) -> bytes:
        try:
            if not self._connection.poll(wait_s):
                raise TimeoutError(f"no answer within {wait_s:g} s")
            kind = self._connection.recv_bytes()
            content = self._connection.recv_bytes()
        except EOFError as error:
            self.end()
            raise BrokenPipeError("the process has died") from error
        except OSError:  # TimeoutError is one
            self.end()
            raise
        if kind == FAILED:
            raise FitFailed(content.decode())
        return content


def _serve(connection: Connection, opener: Callable[..., Answerer], arguments: tuple[Any, ...], memory: int) -> None:
    limit_process(memory, None)

    def reply(make: Callable[[], bytes]) -> bool:
        try:
            content, kind = make(), ANSWERED
        except BreastRigError as error:
            content, kind = str(error).encode(), FAILED
        connection.send_bytes(kind)
        connection.send_bytes(content)
        return kind == ANSWERED

    answerers: list[Answerer] = []

    def opening() -> bytes:
        answerers.append(opener(*arguments))
        return b""

    with suppress(EOFError, OSError):
        if not reply(opening):
            return
        while True:
            question = connection.recv_bytes()
            reply(lambda question=question: answerers[0](question))  # type: ignore[misc]
