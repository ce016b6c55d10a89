"""Tasks that have a key go to the process that is kept for it, while that rests; all others to a process of their own.

A kept process has read its scan already.  What a task may use is the same in both: the limits of memory and of CPU
time are set anew for each task.  Whatever ends a task by force ends its process, and the next task of that key starts
in a process of its own.
"""

import resource
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from breastrig.execution.kept_processes import KeptProcesses
from breastrig.execution.processes import Processes


@dataclass(frozen=True)
class ForKey:
    """A function that is best called where others of its key were; anywhere else it is called as it is."""

    key: str
    function: Callable[..., Any]
    begins: bool = False  # the first of its key: a process is begun for it, where there is a place

    def __call__(self, *given: Any) -> Any:
        return self.function(*given)


class WarmFirst:
    """An Executor: a pool beside kept processes, which other executors may share.

    `within(function, *given)` calls the function in a kept process, and has it keep what it reads.
    """

    def __init__(
        self,
        cold: Processes,
        kept: KeptProcesses,
        within: Callable[..., Any],
        *,
        memory_bytes: int,
        cpu_s: int | None = None,
    ) -> None:
        self._cold, self._kept, self._within = cold, kept, within
        self._limits = (memory_bytes, cpu_s)

    @property
    def workers(self) -> int:
        return self._cold.workers

    def warm_up(self) -> None:
        self._cold.warm_up()
        self._kept.stand_ready()

    def schedule(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> "Future[Any]":
        """As Processes.schedule."""
        if isinstance(function, ForKey):
            given = (*self._limits, self._within, function.function, *args)
            begun = self._kept.begin(function.key, call_limited, given, timeout, function.begins)
            if begun is not None:
                return begun
        future: Future[Any] = self._cold.schedule(function, args, timeout)
        return future

    def answer(self, wait_s: float) -> bool:
        return self._cold.answer(wait_s)

    def stop(self) -> None:
        """Ends the kept processes too."""
        self._cold.stop()
        self._kept.stop()


def call_limited(memory_bytes: int, cpu_s: int | None, function: Callable[..., Any], *given: Any) -> Any:
    """In a kept process: what the function gives, within limits that count from now."""
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes if most < 0 else min(memory_bytes, most), most))
    used = resource.getrusage(resource.RUSAGE_SELF)
    until = resource.RLIM_INFINITY if cpu_s is None else int(used.ru_utime + used.ru_stime) + 1 + cpu_s
    resource.setrlimit(resource.RLIMIT_CPU, (until, resource.getrlimit(resource.RLIMIT_CPU)[1]))
    return function(*given)
