"""Worker processes that can be timed out and killed, one task each.

A process executes one task and is replaced: nothing of one patient's data is left for the next task, a task
that is killed can never take another one with it, and limits of memory and CPU time hold for each task alone.
That is cheap because a fork server has imported everything once (see fork_server.py): the next process is ready,
waiting, when the task arrives.

Tried and dropped: long-lived workers.  When a task is cancelled at the moment at which it ends, Pebble may kill
the process that has already begun the next one.
"""

import gc
import multiprocessing
import os
import resource
import threading
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any

from pebble import ProcessFuture, ProcessPool
from threadpoolctl import threadpool_limits

from breastrig.core.log_lines import set_up_logs_from_environment
from breastrig.execution.fork_server import modules_to_preload

ANSWER_S = 30.0  # until a process is asked again; importing everything takes a few on a slow machine
TIMES_ASKED = 3


class Processes:
    """A pool that survives the loss of any of its processes."""

    def __init__(
        self, workers: int, *, memory_bytes: int, cpu_s: int | None = None, tasks_each: int = 1, spare: int = 0
    ) -> None:
        """`tasks_each` 0: a process is not replaced after its tasks; for one that serves the same data again.

        `spare` processes stand ready beside the `workers`, for callers who hand over no more than `workers` tasks at
        once: Pebble looks for ended processes ten times a second, and the next task need not wait for that.
        """
        self.workers = workers
        self._processes = workers + spare
        self._tasks_each = tasks_each
        self._limits = (memory_bytes, cpu_s)
        self._lock = threading.Lock()
        self._stopped = False
        self._unfinished = 0
        self._context = _LockKeepingContext()
        self._pool = self._new_pool()

    def warm_up(self) -> None:
        """Starts the processes and waits until one has answered.  Raises RuntimeError when none does."""
        for _ in range(TIMES_ASKED):
            future = self.schedule(_nothing, (), timeout=ANSWER_S)
            try:
                future.result(timeout=ANSWER_S)
                return
            except TimeoutError:  # Pebble forgets a task whose process dies as it is handed over
                future.cancel()
        raise RuntimeError("No process answers: the machine may have no memory left for one.")

    def schedule(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> "ProcessFuture[Any]":
        """Runs `function(*args)` in a process of its own.  Both must be importable there by name.

        The future ends with the result, the function's own exception, TimeoutError, or an OSError or RuntimeError
        when the process died; `cancel` kills the process.
        """
        with self._lock:
            if self._stopped:
                raise RuntimeError("the processes are stopped")
            try:
                future = self._pool.schedule(function, args, timeout=timeout)
            except RuntimeError:  # an idle process was killed from outside, which breaks the pool
                self._end_pool()
                self._pool = self._new_pool()
                future = self._pool.schedule(function, args, timeout=timeout)
            self._unfinished += 1
        future.add_done_callback(self._one_less)
        return future

    def result(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> Any:
        """What `schedule` brings, for a function that may be begun twice.

        Processes that only wait for work may be killed from outside, when memory is short; the task that one of them
        would have had never began, and is tried once more.
        """
        try:
            return self.schedule(function, args, timeout).result()
        except BrokenProcessPool:
            return self.schedule(function, args, timeout).result()

    def answer(self, wait_s: float) -> bool:
        """Whether a process executes a task; taken for granted while all are at work."""
        if self._unfinished >= self.workers:
            return not self._stopped
        try:
            self.schedule(_nothing, (), timeout=wait_s).result(timeout=wait_s)
        except (OSError, RuntimeError, TimeoutError):
            return False
        return True

    def stop(self) -> None:
        """Kills what still runs and waits until it is gone."""
        with self._lock:
            self._stopped = True
            self._end_pool()

    def _one_less(self, _future: Any) -> None:
        self._unfinished -= 1

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            self._processes,
            max_tasks=self._tasks_each,
            initializer=_limit,
            initargs=self._limits,
            context=self._context,
        )

    def _end_pool(self) -> None:
        self._pool.stop()
        with suppress(RuntimeError):
            self._pool.join()
        self._context.locks.clear()


class _LockKeepingContext:
    """The fork server, and a hold on every lock that it made.

    A stopping pool lets go of its locks, which removes them from the system, before it kills its processes; one
    that is only starting then would not find them, and would die with a traceback.
    """

    def __init__(self) -> None:
        self._server = multiprocessing.get_context("forkserver")
        self._server.set_forkserver_preload(modules_to_preload())
        self.locks: list[Any] = []

    def RLock(self) -> Any:
        self.locks.append(self._server.RLock())
        return self.locks[-1]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)


def _limit(memory_bytes: int, cpu_s: int | None) -> None:
    """In the child, before its task."""
    gc.freeze()  # what is imported lasts as long as the process, so it need not be looked through
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a core dump would hold a patient's scan
    if cpu_s is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 5))
    set_up_logs_from_environment()
    threading.Thread(target=_die_with_the_server, daemon=True).start()
    threadpool_limits(1)  # more are slower at this size, and fits would fight over the cores


def _die_with_the_server() -> None:
    """A server that is killed cannot stop its processes; each one notices by itself."""
    server = multiprocessing.parent_process()
    if server is not None:
        server.join()
        os._exit(1)


def _nothing() -> None:
    pass
