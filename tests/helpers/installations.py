"""The two ways to run the service: its own processes carry out the fits, or a Dask cluster on its machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from breastrig.execution.executor import Executor
from helpers.dask_cluster import Cluster, scheduler, wait_until_ready

MEMORY_BYTES = 6 * 2**30


class Installation(Protocol):
    name: str

    def executor(self) -> Executor | None:
        """Who carries out fits; None: processes of the service's own."""


class Small:
    """Local processes."""

    name = "local"

    def executor(self) -> Executor | None:
        return None


@dataclass(frozen=True)
class Large:
    """A Dask cluster."""

    cluster: Cluster
    name = "dask"

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
