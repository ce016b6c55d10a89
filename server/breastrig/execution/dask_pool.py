"""A Dask cluster in the place of local processes: `schedule`, `cancel` and the errors are the same.

What differs is what a cluster is for: a worker that is lost has its tasks started again on another one (Dask does
that by itself, up to `distributed.scheduler.allowed-failures` times), and workers may come and go; while there are
none, tasks wait.  A task whose own child process died is not tried again, as it would only die again.

All of the client's work happens in one event loop in a thread of its own, and futures are ended in other threads,
so that a slow callback never holds up the connection.
"""

import asyncio
import importlib
import logging
import secrets
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import CancelledError, Future, InvalidStateError, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any

from breastrig.core.errors import BadSettings
from breastrig.execution.dask_task import RESOURCE, Limits, execute, packed, still_running, unpacked

CONNECT_S = 10.0  # a scheduler that is there answers within a second
COUNT_S = 1.0  # between two counts of the workers
GONE_S = 10.0  # a stopping pool waits so long for the children; a child is asked to end, and after 3 s made to
CALLBACK_THREADS = 4  # they mostly wait for the database

UNREACHABLE = (
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)  # as distributed says it, also of protocol and certificates
MISSING = "A cluster needs the package distributed; install it with: pip install 'breastrig[dask]'."
LOST = "The scheduler was lost."

log = logging.getLogger(__name__)


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

    def __init__(self, address: str, *, memory_bytes: int, cpu_s: int | None = None) -> None:
        package = distributed()
        self._config = importlib.import_module("dask").config
        self._limits: Limits = (memory_bytes, cpu_s)
        self._lock = threading.Lock()
        self._stopped = False
        self._tasks: set[_Task] = set()
        self._addresses: dict[str, int] = {}  # worker -> tasks that it takes at once
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(_note_unheard)
        self._thread = threading.Thread(target=self._loop.run_forever, name="dask pool", daemon=True)
        self._thread.start()
        self._callbacks = ThreadPoolExecutor(CALLBACK_THREADS, thread_name_prefix="dask callback")
        self._connect = partial(_connected, package.Client, address)
        try:
            self._client = self._soon(self._connect()).result()
            self._soon(self._count()).result()
        except UNREACHABLE as error:
            self._end_threads()
            raise BadSettings(no_scheduler(address)) from error
        self._watch = self._soon(self._count_on())

    @property
    def workers(self) -> int:
        """Tasks that the cluster takes at once; at least 1, so that a caller leaves a task for the first to come."""
        return max(1, sum(self._addresses.values()))

    @property
    def found_workers(self) -> int:
        """The same, 0 while no worker of this version is there."""
        return sum(self._addresses.values())

    def warm_up(self) -> None:
        """Waits until a worker has answered; not at all while there is none, for one may come at any time."""
        if self.found_workers:
            self.schedule(_nothing, (), timeout=60.0).result()

    def schedule(self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> "Future[Any]":
        """As Executor says.  A ConnectionError ends the future when the scheduler was lost."""
        call = packed(function, args)
        with self._lock:
            if self._stopped:
                raise RuntimeError("the pool is stopped")
            task = _Task(self)
            self._tasks.add(task)
        self._soon(self._carry(task, call, timeout))
        return task

    def answer(self, wait_s: float) -> bool:
        """Whether the scheduler answers and has a worker of this version."""
        if self._stopped:
            return False
        asked = self._soon(self._count())
        try:
            asked.result(timeout=wait_s)
        except (OSError, TimeoutError, CancelledError):
            asked.cancel()
            return False
        return self.found_workers > 0

    def stop(self) -> None:
        """Kills this client's tasks, waits until their processes are gone, and leaves the cluster."""
        with self._lock:
            if self._stopped:
                return
            self._stopped = True
            tasks = list(self._tasks)
        keys = [task.key for task in tasks]
        for task in tasks:
            task.cancel()
        with suppress(OSError, TimeoutError, CancelledError):
            self._soon(self._leave(keys)).result(timeout=2 * GONE_S)
        self._end_threads()

    def forget(self, task: "_Task") -> None:
        """In the thread that cancelled it: nobody wants the task any more."""
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._release, task)

    def _soon(self, work: Coroutine[Any, Any, Any]) -> "Future[Any]":
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def _release(self, task: "_Task") -> None:
        remote, task.remote = task.remote, None
        self._tasks.discard(task)
        if remote is not None:
            remote.release()  # the only holder; so the scheduler takes the task from its worker

    async def _count(self) -> None:
        scheduler = self._client.scheduler
        if scheduler is None:
            raise ConnectionError(LOST)
        found = await scheduler.identity(n_workers=-1)
        offers = {name: int(each["resources"].get(RESOURCE, 0)) for name, each in found["workers"].items()}
        self._addresses = {name: offer for name, offer in offers.items() if offer}

    async def _count_on(self) -> None:
        """Again and again; a client that has given up on its scheduler is replaced, for it may have been restarted."""
        while True:
            try:
                if self._client.status == "closed":
                    self._client = await self._connect()
                await self._count()
            except OSError:
                self._addresses = {}
            await asyncio.sleep(COUNT_S)

    async def _carry(self, task: "_Task", call: bytes, timeout: float) -> None:
        """From submitting to the future's end."""
        if task.cancelled():
            return
        end: Callable[[], Any]
        try:
            outcome = await self._outcome(task, call, timeout)
            end = partial(unpacked, outcome)
        except (CancelledError, asyncio.CancelledError):  # without our doing: the connection broke
            end = partial(_raise, ConnectionError(LOST))
        except Exception as error:  # too many workers died of it, or there is no scheduler now
            lost = OSError(f"The task was lost on its workers ({type(error).__name__}).")
            end = partial(_raise, lost if self._client.status == "running" else ConnectionError(LOST))
        self._release(task)
        with suppress(RuntimeError):  # the pool is stopped, and the task cancelled
            self._callbacks.submit(task.settle, end)

    async def _outcome(self, task: "_Task", call: bytes, timeout: float) -> bytes:
        # The scan travels inside the task, so that a task whose worker is lost can be started again elsewhere.
        with self._config.set({"distributed.admin.large-graph-warning-threshold": f"{2 * len(call) + 10**7}B"}):
            task.remote = self._client.submit(
                execute,
                call,
                timeout,
                self._limits,
                key=task.key,
                pure=False,
                retries=0,  # an exception here would be an exception again
                resources={RESOURCE: 1},
            )
        outcome: bytes = await task.remote
        return outcome

    async def _leave(self, keys: list[str]) -> None:
        """Waits until no worker has a child for these tasks, then closes the connection."""
        self._watch.cancel()
        until = self._loop.time() + GONE_S
        while keys and self._addresses and self._loop.time() < until:
            found = await self._client.run(still_running, keys, workers=list(self._addresses), on_error="ignore")
            if not any(found.values()):
                break
            await asyncio.sleep(0.05)
        await self._client.close()

    def _end_threads(self) -> None:
        self._callbacks.shutdown(wait=True)
        asyncio.run_coroutine_threadsafe(_end_others(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


class _Task(Future[Any]):
    """The caller's view of one task."""

    def __init__(self, pool: DaskPool) -> None:
        super().__init__()
        self.key = f"task-{secrets.token_hex(16)}"  # says nothing about its content and cannot be guessed
        self.remote: Any = None  # distributed's future, touched in the pool's loop only
        self._pool = pool
        self._cancelling = threading.RLock()  # callbacks may cancel, too

    def cancel(self) -> bool:
        """Ends the future at once, and its process soon after."""
        with self._cancelling:
            before = self.cancelled()
            if not super().cancel():
                return False
            if not before:
                self.set_running_or_notify_cancel()  # so that concurrent.futures.wait sees the end
        self._pool.forget(self)
        return True

    def settle(self, end: Callable[[], Any]) -> None:
        """In a thread for callbacks."""
        with suppress(InvalidStateError):  # cancelled in the meantime
            try:
                value = end()
            except BaseException as error:
                self.set_exception(error)
            else:
                self.set_result(value)


def _note_unheard(_loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Of a connection that closes, timers are left whose end nobody awaits; asyncio would print them."""
    log.debug("%s", context.get("message"))


def _raise(error: Exception) -> None:
    raise error


def _nothing() -> None:
    pass


async def _connected(client_type: Any, address: str) -> Any:
    client = client_type(address, asynchronous=True, set_as_default=False, timeout=CONNECT_S)
    try:
        return await client
    except BaseException:
        await client.close()
        raise


async def _end_others() -> None:
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for other in others:
        other.cancel()
    await asyncio.gather(*others, return_exceptions=True)
