"""The processes that read uploads and make reports, shared fairly between clients.

Pebble's own queue is first come, first served: one client with many slow scans would keep everybody waiting.  So no
more tasks are handed to it than it has processes; the others wait here and are taken in turns, one of each client.
How many a client may have here is limited, because each holds a thread of the server.

Uploads come before all else, and one task more may run than there are workers, as long as not all are of one kind: so
an upload waits for no report or search of another person, and these are not kept out by a row of uploads.  One more
place, of either kind, is for clients who have no task in work: however long those of another take, they begin at once.
"""

import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from typing import Any

from breastrig.core.errors import TooMany
from breastrig.core.round_robin import RoundRobin
from breastrig.execution.client_key import client_key
from breastrig.execution.executor import Executor
from breastrig.execution.warm_first import ForKey

RETRY_S = 2  # a scan is read within a second or two


class _Task(Future[Any]):
    """What the caller holds; ends as the process's own future does."""

    def __init__(self, lane: "_Lane", owner: "FairProcesses", client: str, call: Callable[[], "Future[Any]"]) -> None:
        super().__init__()
        self.lane = lane
        self.client = client
        self.call = call
        self.inner: Future[Any] | None = None
        self._owner = owner
        self._once = threading.RLock()

    def cancel(self) -> bool:
        return self._owner.withdraw(self)

    def end_cancelled(self) -> None:
        with self._once:
            if not self.done() and super().cancel():
                self.set_running_or_notify_cancel()  # wakes those who wait for it


class _Lane:
    """Tasks of one kind."""

    def __init__(self) -> None:
        self.waiting: RoundRobin[_Task] = RoundRobin()
        self.running: Counter[str] = Counter()  # tasks in a process, by client

    def of(self, client: str) -> int:
        """How many tasks the client has here."""
        return self.waiting.waiting(client) + self.running[client]


class FairProcesses:
    """An Executor around a pool.  `waiting_per_client` counts what a client has under way or waiting."""

    def __init__(self, processes: Executor, waiting_per_client: int) -> None:
        self._processes = processes
        self._most = waiting_per_client
        self._changed = threading.Condition()
        self._uploads, self._others = self._lanes = _Lane(), _Lane()
        self._handed_over: set[_Task] = set()
        self._stopped = False
        self._thread = threading.Thread(target=self._hand_over, name="breastrig-readers", daemon=True)

    @property
    def workers(self) -> int:
        return self._processes.workers

    def warm_up(self) -> None:
        self._processes.warm_up()
        self._thread.start()

    def schedule(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> "Future[Any]":
        """As `Processes.schedule`; `timeout` counts from the start of the task.

        Raises TooMany when the client that asks has as many tasks here as one may have.
        """
        client = client_key.get()
        lane = self._uploads if isinstance(function, ForKey) and function.begins else self._others
        task = _Task(lane, self, client or "", lambda: self._processes.schedule(function, args, timeout))
        with self._changed:
            if self._stopped:
                raise RuntimeError("the processes are stopped")
            if client is not None and sum(each.of(client) for each in self._lanes) >= self._most:
                raise TooMany(
                    f"{self._most} of your scans and reports are being worked on, as many as one client may have; "
                    f"ask again in {RETRY_S} s.",
                    RETRY_S,
                )
            lane.waiting.put(task.client, task)
            self._changed.notify_all()
        return task

    def result(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> Any:
        """As `Processes.result`: tried once more when the process was lost before it began."""
        try:
            return self.schedule(function, args, timeout).result()
        except BrokenProcessPool:
            return self.schedule(function, args, timeout).result()

    def answer(self, wait_s: float) -> bool:
        return self._processes.answer(wait_s)

    def stop(self) -> None:
        """Kills what runs, and ends what waits with a RuntimeError."""
        left = []
        with self._changed:
            self._stopped = True
            for lane in self._lanes:
                while (taken := lane.waiting.take()) is not None:
                    left.append(taken[1])
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join()
        self._processes.stop()
        for task in (*left, *list(self._handed_over)):  # a pool that stops may forget what it was about to begin
            with suppress(InvalidStateError):  # it has ended
                task.set_exception(RuntimeError("the processes are stopped"))

    def withdraw(self, task: _Task) -> bool:
        """Ends a task that nobody wants any more; kills its process when it has one."""
        with self._changed:
            waited, inner = task.lane.waiting.discard(task.client, task), task.inner
        if inner is not None:
            return bool(inner.cancel())
        task.end_cancelled()
        return waited

    def _hand_over(self) -> None:
        """In a thread of its own: the end of a task is notified in a thread that may hold the pool's lock."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopped or self._free_lane() is not None)
                lane = self._free_lane()
                if self._stopped or lane is None:
                    return
                taken = lane.waiting.take(partial(self._may_begin, lane))
                assert taken is not None
                client, task = taken
                lane.running[client] += 1
                self._handed_over.add(task)
            try:
                inner = task.call()
            except Exception as error:
                self._one_less(task)
                with suppress(InvalidStateError):
                    task.set_exception(error)
                continue
            task.inner = inner
            inner.add_done_callback(partial(self._end, task))
            if task.cancelled():  # between the queue and the process
                inner.cancel()

    def _free_lane(self) -> _Lane | None:
        """One with a task that can begin now, uploads first; holding the lock."""
        return next((lane for lane in self._lanes if lane.waiting.has(partial(self._may_begin, lane))), None)

    def _may_begin(self, lane: _Lane, client: str) -> bool:
        """Whether there is a place in this lane for one more task of the client; holding the lock."""
        own = 0 if any(each.running[client] for each in self._lanes) else 1
        all_running = sum(each.running.total() for each in self._lanes)
        return lane.running.total() < self.workers + own and all_running < self.workers + 1 + own

    def _end(self, task: _Task, ended: "Future[Any]") -> None:
        self._one_less(task)
        with suppress(InvalidStateError):
            if ended.cancelled():
                task.end_cancelled()
            elif (error := ended.exception()) is not None:
                task.set_exception(error)
            else:
                task.set_result(ended.result())

    def _one_less(self, task: _Task) -> None:
        with self._changed:
            self._handed_over.discard(task)
            task.lane.running[task.client] -= 1
            task.lane.running += Counter()  # forgets clients with none
            self._changed.notify_all()
