"""The pool of this machine's processes: fair between clients, and with a process that stays for each key in use.

A task has a process of its own, which ends with it: nothing of one patient's data is left for the next task, and a task
that is killed takes no other one with it.  A task with a key finds the process that an earlier task of this key has
left, when that rests, and leaves its own to the next; only so many are kept, those used last.

A pool has queues, one a kind of task, so that one kind does not keep another waiting.  In a queue clients take turns,
and one more task than it has workers may run for a client who has none there: however long the tasks of others take, a
worker is left.
"""

import threading
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import Future
from contextvars import ContextVar
from itertools import count
from typing import Any, TypeVar

from breastrig.core.errors import BreastRigError, TooMany
from breastrig.execution.executor import STOPPED, Task, nothing
from breastrig.execution.worker import Answer, NotBegun, Worker, packed

Result = TypeVar("Result")

client_key: ContextVar[str | None] = ContextVar("client_key", default=None)
"""For whom the work at hand is done; set at the beginning of each request.  None is the program itself."""

LARGE_BYTES = 800 * 2**20  # of memory at rest, beyond which no process is kept; a usual scan with colours leaves half
RETRY_S = 2  # most tasks take a second or two
STARTS = 3  # processes that may end before they begin a task: idle ones are killed where memory is short
ENDED = "The process of this task was ended."
NO_PROCESS = "No process answers: the machine may have no memory left for one."


class _Call(Task):
    """A task of a queue."""

    def __init__(self, queue: "TaskQueue", client: str, call: bytes, timeout: float, key: str | None) -> None:
        super().__init__(queue.pool.withdraw)
        self.queue, self.client, self.call, self.timeout, self.key = queue, client, call, timeout, key
        self.worker: Worker | None = None
        self.thread = threading.Thread(target=queue.pool.run, args=(self,), name="breastrig-task", daemon=True)


class TaskQueue:
    """An Executor: worker slots for tasks of one kind."""

    def __init__(self, pool: "Pool", workers: int, memory_bytes: int, per_client: int | None) -> None:
        self.pool, self.workers, self.memory_bytes, self.per_client = pool, workers, memory_bytes, per_client
        self.waiting: list[_Call] = []
        self.running: Counter[str] = Counter()  # by client
        self.turns: dict[str, int] = {}  # when each client was last served, while others wait

    def schedule(
        self, function: Callable[..., Result], args: tuple[Any, ...], timeout: float, key: str | None = None
    ) -> "Future[Result]":
        """Runs a task as Executor.schedule; `timeout` counts from the start of the task.

        Raises TooMany when the client that asks has as many tasks in this queue as one may have.
        """
        return self._scheduled(client_key.get(), function, args, timeout, key)

    def result(
        self, function: Callable[..., Result], args: tuple[Any, ...], timeout: float, key: str | None = None
    ) -> Result:
        """The task's result; blocks."""
        return self.schedule(function, args, timeout, key).result()

    def warm_up(self) -> None:
        self._scheduled(None, nothing, (), 60.0).result()

    def answer(self, wait_s: float) -> bool:
        """Taken for granted while all are at work."""
        if self.running.total() >= self.workers:
            return not self.pool.is_stopped
        try:
            self._scheduled(None, nothing, (), wait_s).result(wait_s)
        except (OSError, RuntimeError, TimeoutError):
            return False
        return True

    def stop(self) -> None:
        """Stops the whole pool."""
        self.pool.stop()

    def _scheduled(
        self,
        client: str | None,
        function: Callable[..., Any],
        args: tuple[Any, ...],
        timeout: float,
        key: str | None = None,
    ) -> "Future[Any]":
        task = _Call(self, client or "", packed(function, args), timeout, key)
        self.pool.add(task, counts=client is not None)
        return task


class Pool:
    """May be used from any thread."""

    def __init__(self, most_idle: int = 0, large_bytes: int = LARGE_BYTES) -> None:
        """`most_idle` processes rest at most."""
        self._most_idle, self._large_bytes = most_idle, large_bytes
        self._lock = threading.RLock()
        self._queues: list[TaskQueue] = []
        self._running: set[_Call] = set()
        self._idle: deque[Worker] = deque()  # the one used last is the last
        self._turn = count()
        self.is_stopped = False

    def queue(self, workers: int, memory_bytes: int, per_client: int | None = None) -> TaskQueue:
        """`memory_bytes` is of address space, for each task; a client may have `per_client` tasks at once."""
        self._queues.append(TaskQueue(self, workers, memory_bytes, per_client))
        return self._queues[-1]

    @property
    def idle_keys(self) -> list[str | None]:
        """The keys of the idle processes."""
        with self._lock:
            return [worker.key for worker in self._idle]

    def drop(self, key: str) -> None:
        """Ends the key's tasks and processes, and waits until they are gone; who waits for one gets a RuntimeError."""
        with self._lock:
            idle = [worker for worker in self._idle if worker.key == key]
            for worker in idle:
                self._idle.remove(worker)
            tasks = [task for task in self._tasks() if task.key == key]
        self._end(tasks, idle, ENDED)

    def stop(self) -> None:
        """Kills what runs, ends what waits with a RuntimeError, and takes nothing more."""
        with self._lock:
            self.is_stopped = True
            idle = list(self._idle)
            self._idle.clear()
            tasks = self._tasks()
        self._end(tasks, idle, STOPPED)

    def add(self, task: _Call, counts: bool) -> None:
        with self._lock:
            if self.is_stopped:
                raise RuntimeError(STOPPED)
            most = task.queue.per_client if counts else None
            own = sum((each.queue, each.client) == (task.queue, task.client) for each in self._tasks())
            if most is not None and own >= most:
                raise TooMany(
                    f"{most} of your tasks on scans and reports are being worked on, as many as one client may have; "
                    f"ask again in {RETRY_S} s.",
                    RETRY_S,
                )
            task.queue.waiting.append(task)
            self._begin(task.queue)

    def withdraw(self, task: Task) -> None:
        """Removes the task; called in the thread that has ended it."""
        assert isinstance(task, _Call)
        with self._lock:
            if task in task.queue.waiting:
                task.queue.waiting.remove(task)
            if task.worker is not None:
                task.worker.kill()

    def run(self, task: _Call) -> None:
        """Runs the task, in its own thread, from its process to the end of the future."""
        answer = Answer(None, RuntimeError(NO_PROCESS))
        for _ in range(STARTS):
            try:
                answer = self._answer(task)
            except NotBegun:
                continue
            except Exception as error:
                answer = Answer(None, error)
            break
        with self._lock:
            self._running.discard(task)
            task.queue.running[task.client] -= 1
            task.queue.running += Counter()  # forgets clients with none
            self._begin(task.queue)
        task.settle(answer.value, answer.error)

    def _answer(self, task: _Call) -> Answer:
        worker = self._idle_worker(task.key) or Worker(task.key)
        keeps = False
        try:
            with self._lock:
                task.worker = worker
                if task.done():  # in the meantime
                    raise RuntimeError(ENDED)
            answer = worker.call(task.call, task.queue.memory_bytes, task.timeout)
            keeps = answer.error is None or isinstance(answer.error, BreastRigError)
            keeps = keeps and task.key is not None and answer.resident_bytes <= self._large_bytes
            return answer
        finally:
            with self._lock:
                task.worker = None
                surplus = [] if keeps and not task.done() and not self.is_stopped else [worker]
                if not surplus:
                    self._idle.append(worker)
                    surplus = [self._idle.popleft()] if len(self._idle) > self._most_idle else []
            for each in surplus:
                each.end()

    def _idle_worker(self, key: str | None) -> Worker | None:
        with self._lock:
            for worker in reversed(self._idle):
                if worker.key == key:
                    self._idle.remove(worker)
                    return worker
        return None

    def _begin(self, queue: TaskQueue) -> None:
        """Starts tasks that may run; call with the lock held."""
        while able := [task for task in queue.waiting if self._may_begin(task)]:
            task = min(able, key=lambda each: queue.turns.get(each.client, -1))
            queue.waiting.remove(task)
            queue.turns[task.client] = next(self._turn)
            queue.running[task.client] += 1
            self._running.add(task)
            task.thread.start()
        if not queue.waiting:
            queue.turns.clear()

    def _may_begin(self, task: _Call) -> bool:
        queue = task.queue
        return queue.running.total() < queue.workers + (0 if queue.running[task.client] else 1)

    def _tasks(self) -> list[_Call]:
        """The tasks that run or wait; call with the lock held."""
        return [*self._running, *(task for queue in self._queues for task in queue.waiting)]

    def _end(self, tasks: list[_Call], idle: list[Worker], why: str) -> None:
        for task in tasks:
            task.fail(RuntimeError(why))
        for worker in idle:
            worker.end()
        for task in tasks:
            if task.thread.ident is not None and task.thread is not threading.current_thread():
                task.thread.join()
