"""What executes tasks outside of the caller's process: local processes, or a Dask cluster.

A task is a function importable by name and its arguments, both picklable, because it may run in another process on
another machine.  It may be started twice: a machine that is lost has its tasks run again elsewhere.  So a task
writes nothing that a second start could not write again.
"""

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Protocol


class Executor(Protocol):
    """`Processes` here, `DaskPool` on many machines; nothing else differs for the caller."""

    @property
    def workers(self) -> int:
        """Tasks that can run at once now; a cluster may grow and shrink."""

    def warm_up(self) -> None:
        """Returns once a task could start at once.  OSError or RuntimeError when none ever will."""

    def schedule(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> "Future[Any]":
        """Runs `function(*args)` in a process of its own, for `timeout` seconds of wall clock at most.

        The future ends with the result, the function's own exception, TimeoutError, or an OSError or RuntimeError
        when the process died; `cancel` kills the process.  Callbacks run in any thread, also in the one that cancels.
        RuntimeError at once when the executor is stopped.
        """

    def answer(self, wait_s: float) -> bool:
        """Whether tasks are executed; asks for `wait_s` seconds at most."""

    def stop(self) -> None:
        """Kills this caller's tasks that still run and waits until they are gone."""
