"""A Dask cluster in the place of local processes: `schedule`, `cancel` and the errors are the same.

What differs is what a cluster is for: a worker that is lost has its tasks started again on another one (Dask does
that by itself, up to `distributed.scheduler.allowed-failures` times), and workers may come and go; while there are
none, tasks wait.  A task whose own child process died is not tried again, as it would only die again.
"""

import importlib
import logging
import secrets
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from functools import partial
from typing import Any

from breastrig.core.errors import BadSettings
from breastrig.execution.dask_task import RESOURCE, execute, still_running
from breastrig.execution.executor import STOPPED, Task, nothing
from breastrig.execution.worker import Answer, packed, unpacked

CONNECT_S = 10.0  # a scheduler that is there answers within a second
COUNT_S = 1.0  # between two counts of the workers
GONE_S = 10.0  # a stopping pool waits so long for its tasks' processes

UNREACHABLE = (
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)  # as distributed says it, also of protocol and certificates
MISSING = "A cluster needs the package distributed; install it with: pip install 'breastrig[dask]'."
LOST = "The scheduler was lost."


def distributed() -> Any:
    """The package, quiet: what it would print is said by our own sentences.  BadSettings when it is not installed."""
    try:
        import distributed
    except ImportError as error:
        raise BadSettings(MISSING) from error
    for noisy in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(noisy).setLevel(logging.CRITICAL)
    return distributed


def no_scheduler(address: str) -> str:
    """The sentence for an address where no scheduler answers."""
    certificates = (
        " and the certificates in Dask's settings (distributed.comm.tls)" if address.startswith("tls") else ""
    )
    return (
        f"No Dask scheduler answers at {address}; check the address{certificates}, or start one with: dask scheduler."
    )


class DaskPool:
    """An Executor over the workers that `breastrig worker ADDRESS` has started.

    Raises BadSettings when distributed is not installed or no scheduler answers.
    """

    def __init__(self, address: str, *, memory_bytes: int) -> None:
        package = distributed()
        # A scan travels inside its task, so that a task whose worker is lost can be started again elsewhere.
        importlib.import_module("dask").config.set({"distributed.admin.large-graph-warning-threshold": "100GB"})
        self._memory_bytes = memory_bytes
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._tasks: set[_Remote] = set()
        self._offers: dict[str, int] = {}  # worker -> tasks that it takes at once
        self._counted_at = time.monotonic()
        self._connect = partial[Any](package.Client, address, set_as_default=False, timeout=CONNECT_S)
        try:
            self._client = self._connect()
            self._count()
        except UNREACHABLE as error:
            raise BadSettings(no_scheduler(address)) from error
        self._watch = threading.Thread(target=self._count_on, name="breastrig-dask", daemon=True)
        self._watch.start()

    @property
    def workers(self) -> int:
        """Tasks that the cluster takes at once; at least 1, so that a caller leaves a task for the first to come."""
        return max(1, self.found_workers)

    @property
    def found_workers(self) -> int:
        """The number of workers' places, 0 while no worker of this version is there."""
        return sum(self._offers.values())

    def warm_up(self) -> None:
        """Waits until a worker has answered; not at all while there is none, for one may come at any time."""
        if self.found_workers:
            self.schedule(nothing, (), timeout=60.0).result()

    def schedule(
        self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float, key: str | None = None
    ) -> "Future[Any]":
        """Runs a task as Executor.schedule, each in its own process. ConnectionError when the scheduler was lost."""
        call, task = packed(function, args), _Remote(self._withdraw)
        with self._lock:
            if self._stopped.is_set():
                raise RuntimeError(STOPPED)
            self._tasks.add(task)
        given = (call, timeout, self._memory_bytes)
        try:
            task.remote = self._client.submit(
                execute, *given, key=task.key, pure=False, retries=0, resources={RESOURCE: 1}
            )
            task.remote.add_done_callback(lambda _ended: self._settle(task))
        except Exception:  # there is no scheduler now
            task.fail(ConnectionError(LOST))
        return task

    def answer(self, wait_s: float) -> bool:
        """Whether the scheduler has answered lately and has a worker of this version."""
        is_known = time.monotonic() - self._counted_at <= COUNT_S + wait_s
        return not self._stopped.is_set() and is_known and self.found_workers > 0

    def stop(self) -> None:
        """Kills this client's tasks, waits until their processes are gone, and leaves the cluster."""
        with self._lock:
            if self._stopped.is_set():
                return
            self._stopped.set()
            tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        leaving = threading.Thread(target=self._leave, args=([task.key for task in tasks],), daemon=True)
        leaving.start()
        leaving.join(2 * GONE_S)
        self._watch.join(GONE_S)

    def _settle(self, task: "_Remote") -> None:
        """In distributed's thread for callbacks."""
        try:
            answer = unpacked(task.remote.result())
        except CancelledError:  # without our doing: the connection broke
            answer = Answer(None, ConnectionError(LOST))
        except Exception as error:  # too many workers died of it, or there is no scheduler now
            lost = OSError(f"The task was lost on its workers ({type(error).__name__}).")
            answer = Answer(None, lost if self._client.status == "running" else ConnectionError(LOST))
        self._withdraw(task)
        task.settle(answer.value, answer.error)

    def _withdraw(self, task: Task) -> None:
        """The scheduler takes the task from its worker."""
        assert isinstance(task, _Remote)
        with self._lock:
            self._tasks.discard(task)
        if task.remote is not None:
            task.remote.release()

    def _count(self) -> None:
        workers = self._client.scheduler_info(n_workers=-1).get("workers", {})  # of a scheduler that goes, nothing
        offers = {name: int(each["resources"].get(RESOURCE, 0)) for name, each in workers.items()}
        self._offers = {name: offer for name, offer in offers.items() if offer}
        self._counted_at = time.monotonic()

    def _count_on(self) -> None:
        """In a thread; a client that has given up on its scheduler is replaced, for it may have been restarted."""
        while not self._stopped.wait(COUNT_S):
            try:
                if self._client.status == "closed":
                    self._client = self._connect()
                self._count()
            except UNREACHABLE:
                self._offers = {}

    def _leave(self, keys: list[str]) -> None:
        """Waits until no worker has a process for these tasks, then closes the connection."""
        until = time.monotonic() + GONE_S
        try:
            while keys and self._offers and time.monotonic() < until:
                found = self._client.run(still_running, keys, workers=list(self._offers), on_error="ignore")
                if not any(found.values()):
                    break
                time.sleep(0.05)
            self._client.close()
        except (*UNREACHABLE, CancelledError):  # the scheduler is gone, and ends its workers' tasks
            return


class _Remote(Task):
    """The caller's view of one task."""

    def __init__(self, withdraw: Callable[[Task], None]) -> None:
        super().__init__(withdraw)
        self.key = f"task-{secrets.token_hex(16)}"  # says nothing about its content and cannot be guessed
        self.remote: Any = None  # distributed's future
