"""A Dask worker whose tasks run in child processes (see dask_task.py), from its start to its end.

There is no nanny: children of a nanny's process may have no children of their own.  Results are kept in memory and
never spilled to disk, because they are patients' data; they are small, and are fetched as soon as they are there.
"""

import asyncio
import secrets
import signal
import tempfile
from collections.abc import Callable, Iterable
from typing import Any

from breastrig.core.errors import BadSettings
from breastrig.core.scratch import sweep_scratch
from breastrig.execution.dask_pool import CONNECT_S, UNREACHABLE, distributed, no_scheduler
from breastrig.execution.dask_task import RESOURCE, queue_of, stop_children
from breastrig.execution.limits import FitLimits
from breastrig.execution.worker import preload, scratch_swept


def run_worker(address: str, workers: int, on_ready: Callable[[], None], task_modules: Iterable[str] = ()) -> bool:
    """Works until a signal stops it (True), or the scheduler is gone or has let it go (False).

    `task_modules` are what the tasks import: children find them imported already.

    Raises BadSettings when distributed is not installed or no scheduler answers.
    """
    package = distributed()
    preload(task_modules)
    try:
        with scratch_swept(), tempfile.TemporaryDirectory(prefix="breastrig-worker-") as folder:
            return asyncio.run(_work(package, address, workers, folder, on_ready))
    finally:
        stop_children()
        sweep_scratch()


async def _work(package: Any, address: str, workers: int, folder: str, on_ready: Callable[[], None]) -> bool:
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    try:
        worker = await package.Worker(
            address,
            nthreads=workers,
            resources={RESOURCE: workers},
            name=f"breastrig-{secrets.token_hex(4)}",
            memory_limit=0,  # no spilling; each child has a limit of its own
            local_directory=folder,
            dashboard_address="127.0.0.1:0",  # Dask's pages about this worker: for this machine only
            death_timeout=CONNECT_S,
        )
    except UNREACHABLE as error:
        raise BadSettings(no_scheduler(address)) from error
    await asyncio.to_thread(queue_of(FitLimits().memory_bytes, workers).warm_up)
    on_ready()
    stopping = asyncio.create_task(stop.wait())
    ending = asyncio.create_task(worker.finished())
    await asyncio.wait([stopping, ending], return_when=asyncio.FIRST_COMPLETED)
    stopped = stop.is_set()
    stopping.cancel()
    await worker.close(executor_wait=False, reason="stopped")
    await ending
    return stopped
