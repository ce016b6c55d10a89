"""One task inside a Dask worker: what a worker's thread does with it.

The task itself runs in a child process of the worker, so that its limits, its crash and its end by force are the
same as on one machine.  Function, arguments and outcome travel as one opaque piece of bytes each: scheduler and
worker neither unpack nor print them, so nothing of a patient can come into their logs, their pages or their
processes.  A task that ends with an error is an answer too, because Dask logs the arguments of tasks that raise.

How a cancellation comes here: the scheduler notifies the worker that nobody wants the task any more, which marks the
task in the worker's own table, and the thread that waits for the child looks there ten times a second.  It is the same
when the client was killed or cut off, for then the scheduler says so by itself.
"""

import pickle
import threading
from concurrent.futures import wait

from breastrig.core.version import __version__
from breastrig.execution.pool import Pool, TaskQueue
from breastrig.execution.worker import Answer, answered

# Only workers of this program and version offer it, so that no other worker of a shared cluster is given a task.
RESOURCE = f"breastrig-{__version__}"
LOOK_S = 0.1  # between two looks whether the task is still wanted
UNWANTED = ("cancelled", "released", "forgotten")  # states of a task in the worker's table

_lock = threading.Lock()
_queues: dict[int, TaskQueue] = {}  # by memory_bytes
_running: set[str] = set()  # keys of the tasks that have a child now


def execute(call: bytes, timeout: float, memory_bytes: int) -> bytes:
    """In a thread of a Dask worker: answers a `packed` call in a child process; empty when nobody wants it any more."""
    from distributed import get_worker

    worker = get_worker()
    key = str(worker.get_current_task())
    child = queue_of(memory_bytes, worker.state.nthreads).schedule(answered, (call,), timeout)
    _running.add(key)
    try:
        while not wait([child], timeout=LOOK_S).done:
            task = worker.state.tasks.get(key)
            if task is None or task.state in UNWANTED:
                child.cancel()
                return b""
        answer: bytes = child.result()
        return answer
    except (OSError, RuntimeError) as error:
        return pickle.dumps(Answer(None, error))
    finally:
        _running.discard(key)


def still_running(keys: list[str]) -> int:
    """The number of these tasks that have a child here."""
    return len(_running.intersection(keys))


def stop_children() -> None:
    """Kills the children of this worker; for its end."""
    with _lock:
        for queue in _queues.values():
            queue.stop()
        _queues.clear()


def queue_of(memory_bytes: int, workers: int) -> TaskQueue:
    """The worker's slots for tasks with this limit."""
    with _lock:
        if memory_bytes not in _queues:
            _queues[memory_bytes] = Pool().queue(workers, memory_bytes)
        return _queues[memory_bytes]
