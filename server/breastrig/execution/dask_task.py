"""One task inside a Dask worker: what the scheduler moves around, and what a worker's thread does with it.

The task itself runs in a child process of the worker, so that its limits, its crash and its end by force are the
same as on one machine.  Function, arguments and outcome travel as one opaque piece of bytes each: scheduler and
worker neither unpack nor print them, so nothing of a patient can come into their logs, their pages or their
processes.  A task that ends with an error is an outcome too, because Dask logs the arguments of tasks that raise.

How a cancellation comes here: the scheduler notifies the worker that nobody wants the task any more, which marks the
task in the worker's own table, and the thread that waits for the child looks there ten times a second.  That costs
no message, and it is the same when the client was killed or cut off, for then the scheduler says the same by itself.
Tried and dropped: distributed's Event and Variable, which ask the scheduler at each look and do not notice a client
that has vanished.
"""

import pickle
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, wait
from typing import Any

from breastrig import __version__
from breastrig.execution.fork_server import start_fork_server
from breastrig.execution.processes import Processes

# Only workers of this program and version offer it, so that no other worker of a shared cluster is given a task.
RESOURCE = f"breastrig-{__version__}"
LOOK_S = 0.1  # between two looks whether the task is still wanted
UNWANTED = ("cancelled", "released", "forgotten")  # states of a task in the worker's table
DIED = "The process of a task on a worker ended unexpectedly."

Limits = tuple[int, int | None]  # memory_bytes, cpu_s
_lock = threading.Lock()
_pools: dict[Limits, Processes] = {}
_running: set[str] = set()  # keys of the tasks that have a child now


def packed(function: Callable[..., Any], args: tuple[Any, ...]) -> bytes:
    """A call, to be given to `execute`."""
    return pickle.dumps((function, args), protocol=pickle.HIGHEST_PROTOCOL)


def unpacked(outcome: bytes) -> Any:
    """The result that `execute` brought; raises the task's own exception instead."""
    try:
        done, value = pickle.loads(outcome)
    except Exception as error:
        raise RuntimeError(
            "A task's result cannot be read here; client and workers must be the same version."
        ) from error
    if not done:
        raise value
    return value


def execute(call: bytes, timeout: float, limits: Limits) -> bytes:
    """In a thread of a Dask worker: runs the call in a child process, and brings its outcome.

    The outcome is (True, result) or (False, exception), pickled; of a task that nobody wants any more it is empty.
    """
    from distributed import get_worker

    worker = get_worker()
    key = str(worker.get_current_task())
    child = _pool(limits, worker.state.nthreads).schedule(_outcome, (call,), timeout)
    _running.add(key)
    try:
        while not wait([child], timeout=LOOK_S).done:
            task = worker.state.tasks.get(key)
            if task is None or task.state in UNWANTED:
                child.cancel()
                return b""
        outcome: bytes = child.result()
        return outcome
    except CancelledError:  # the pool was renewed, or the worker is stopping
        return pickle.dumps((False, OSError(DIED)))
    except (OSError, RuntimeError, TimeoutError) as error:
        return pickle.dumps((False, _plain(error)))
    finally:
        _running.discard(key)


def get_ready(workers: int, memory_bytes: int) -> None:
    """Before the first task: a process that has imported everything waits for it."""
    pool = _pool((memory_bytes, None), workers)
    start_fork_server()
    pool.warm_up()


def still_running(keys: list[str]) -> int:
    """How many of these tasks have a child here."""
    return len(_running.intersection(keys))


def stop_children() -> None:
    """Kills the children of this worker; for its end."""
    with _lock:
        for pool in _pools.values():
            pool.stop()
        _pools.clear()


def _pool(limits: Limits, workers: int) -> Processes:
    with _lock:
        if limits not in _pools:
            memory_bytes, cpu_s = limits
            _pools[limits] = Processes(workers, memory_bytes=memory_bytes, cpu_s=cpu_s, spare=1)
        return _pools[limits]


def _outcome(call: bytes) -> bytes:
    """In the child."""
    try:
        function, args = pickle.loads(call)
        return pickle.dumps((True, function(*args)), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        return _as_outcome(error)


def _as_outcome(error: Exception) -> bytes:
    """An exception that surely arrives: one that cannot be pickled arrives as its text."""
    try:
        outcome = pickle.dumps((False, error))
        pickle.loads(outcome)
    except Exception:
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
    return outcome


def _plain(error: Exception) -> Exception:
    """The same kind of error without what Pebble attaches to it."""
    for kind in (TimeoutError, OSError):
        if isinstance(error, kind):
            return kind(str(error))
    return RuntimeError(str(error))
