"""Executors of tasks outside of the caller's process: a queue of the local pool, or a Dask cluster.

A task is a function importable by name and its arguments, both picklable, because it may run in another process on
another machine. It may be started twice: a machine that is lost has its tasks run again elsewhere. So a task writes
nothing that a second start could not write again.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any, Protocol

STOPPED = "The pool is stopped."


class Executor(Protocol):
    """`TaskQueue` here, `DaskPool` on many machines; nothing else differs for the caller."""

    @property
    def workers(self) -> int:
        """Tasks that can run at once now; a cluster may grow and shrink."""

    def warm_up(self) -> None:
        """Returns once a task could start at once.  OSError or RuntimeError when none ever will."""

    def schedule(
        self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float, key: str | None = None
    ) -> "Future[Any]":
        """Runs `function(*args)` in another process, for `timeout` seconds of wall clock at most.

        Tasks of one key, and none of another, may follow each other in one process; one without a key has its own.
        The future ends with the result, the function's own exception, TimeoutError, or an OSError or RuntimeError
        when the process died; `cancel` kills the process.  Callbacks run in any thread, also in the one that cancels.
        RuntimeError at once when the executor is stopped.
        """

    def answer(self, wait_s: float) -> bool:
        """Whether tasks are executed; asks for `wait_s` seconds at most."""

    def stop(self) -> None:
        """Kills this caller's tasks that still run and waits until they are gone."""


class Task(Future[Any]):
    """A future that can be cancelled, or ended otherwise, while its task runs: it ends at once, its process after."""

    def __init__(self, withdraw: Callable[["Task"], None]) -> None:
        super().__init__()
        self._withdraw = withdraw  # called when nobody wants the task any more
        self._once = threading.RLock()  # callbacks may cancel, too

    def cancel(self) -> bool:
        with self._once:
            before = self.cancelled()
            if not super().cancel():
                return False
            if not before:
                self.set_running_or_notify_cancel()  # so that concurrent.futures.wait sees the end
        self._withdraw(self)
        return True

    def settle(self, value: Any, error: BaseException | None = None) -> None:
        """Ends it with the value or the error, if it has not ended."""
        with suppress(InvalidStateError):
            if error is None:
                self.set_result(value)
            else:
                self.set_exception(error)

    def fail(self, error: BaseException) -> None:
        """Ends it with this error, and its process soon after."""
        self.settle(None, error)
        self._withdraw(self)


def nothing() -> None:
    """A task that does nothing, to test that an executor answers."""
