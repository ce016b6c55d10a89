"""A service whose fits a Dask cluster on its machine carries out."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from breastrig.execution.executor import Executor
from helpers.dask_cluster import Cluster, scheduler, wait_until_ready

MEMORY_BYTES = 6 * 2**30


@dataclass(frozen=True)
class Large:
    """A Dask cluster."""

    cluster: Cluster

    def executor(self) -> Executor:
        from breastrig.execution.dask_pool import DaskPool

        return DaskPool(self.cluster.address, memory_bytes=MEMORY_BYTES)


@contextmanager
def two_workers(folder: Path) -> Iterator[Cluster]:
    """A Dask scheduler with two workers."""
    with scheduler(folder) as found:
        for worker in [found.start_worker(1) for _ in range(2)]:
            wait_until_ready(worker)
        yield found
