"""A Dask cluster on loopback for tests: a scheduler and `breastrig worker`s, each a process of its own.

What Dask's dashboard would show is hardly ever measured: three idle processes took a fifteenth of a core for it.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from helpers.waiting import until

TESTS = Path(__file__).resolve().parents[1]
PLACES = os.pathsep.join(filter(None, (str(TESTS), os.environ.get("PYTHONPATH"))))
UNSEEN = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "10s",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "500ms",
}
REAL = ("-m", "breastrig.cli.main", "worker")
LIGHT = ("-m", "helpers.light_worker")  # whose tasks need none of the numerics
ENVIRONMENT = os.environ | UNSEEN | {"PYTHONPATH": PLACES, "OPENBLAS_NUM_THREADS": "1"}


@dataclass
class Cluster:
    """Its processes; `folder` keeps what they say."""

    folder: Path
    scheduler: subprocess.Popen[bytes]
    program: tuple[str, ...]  # of a worker, for Python
    address: str = ""
    workers: list[subprocess.Popen[str]] = field(default_factory=list)

    def start_worker(self, tasks_at_once: int = 1, **environment: str) -> subprocess.Popen[str]:
        """A worker that may not be ready yet."""
        command = [sys.executable, *self.program, self.address, "--workers", str(tasks_at_once)]
        with (self.folder / f"worker{len(self.workers)}.log").open("w") as log:
            worker = subprocess.Popen(
                command, env=ENVIRONMENT | environment, stdout=subprocess.PIPE, stderr=log, text=True
            )
        self.workers.append(worker)
        return worker

    def said(self) -> str:
        """All that scheduler and workers have logged."""
        return "".join(file.read_text() for file in sorted(self.folder.glob("*.log")))


def wait_until_ready(worker: subprocess.Popen[str]) -> None:
    assert worker.stdout is not None
    assert worker.stdout.readline() == "Ready for work.\n"


@contextmanager
def cluster(folder: Path, program: tuple[str, ...], workers: int = 2) -> Iterator[Cluster]:
    """A scheduler with so many workers that are ready; all are killed at the end."""
    with scheduler(folder, program=program) as found:
        for worker in [found.start_worker(1) for _ in range(workers)]:
            wait_until_ready(worker)
        yield found


@contextmanager
def scheduler(folder: Path, *options: str, program: tuple[str, ...] = REAL) -> Iterator[Cluster]:
    """A scheduler without workers."""
    place = folder / "scheduler.json"
    command = [sys.executable, "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", "0"]
    command += ["--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(place), *options]
    with (folder / "scheduler.log").open("w") as log:
        found = Cluster(folder, subprocess.Popen(command, env=ENVIRONMENT, stderr=log, cwd=folder), program)
    try:
        until(lambda: place.exists() and place.read_text().rstrip().endswith("}"), "the scheduler")
        found.address = json.loads(place.read_text())["address"]
        yield found
    finally:
        for process in (*found.workers, found.scheduler):
            process.kill()
            process.wait()
        for worker in found.workers:
            if worker.stdout is not None:
                worker.stdout.close()
