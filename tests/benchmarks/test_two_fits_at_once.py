"""Two fits in two processes, one BLAS thread each: how much each loses against a fit that has the machine alone."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

WORKER = Path(__file__).with_name("fit_worker.py")
ROUNDS, SECONDS = 5, 1.5


class Worker:
    """A process that fits for as long as it is told."""

    def __init__(self, scan: Path) -> None:
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(WORKER.parents[1])}
        command = [sys.executable, str(WORKER), str(scan)]
        self._process = subprocess.Popen(
            command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert self.answer() == "ready"

    def start(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{SECONDS}\n")
        self._process.stdin.flush()

    def answer(self) -> Any:
        assert self._process.stdout is not None
        return json.loads(self._process.stdout.readline())

    def close(self) -> None:
        self._process.communicate(timeout=30)  # its input ends, so it ends


@pytest.fixture
def workers(scan_50k: Path) -> Iterator[list[Worker]]:
    pair = [Worker(scan_50k), Worker(scan_50k)]
    yield pair
    for worker in pair:
        worker.close()


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="needs two cores")
def test_two_fits_at_once(benchmark: Any, row: Callable[..., None], workers: list[Worker]) -> None:
    alone: list[np.ndarray] = []
    together: list[np.ndarray] = []

    def median_fit(running: list[Worker]) -> np.ndarray:
        """(2,) seconds, and seconds of the processor"""
        for worker in running:
            worker.start()
        return np.mean([np.median(worker.answer(), axis=0) for worker in running], axis=0)

    def one_round() -> None:
        alone.append(np.mean([median_fit([worker]) for worker in workers], axis=0))
        together.append(median_fit(workers))

    benchmark.pedantic(one_round, rounds=ROUNDS, warmup_rounds=0)
    loss, processor = np.median(100.0 * (np.array(together) / np.array(alone) - 1.0), axis=0)
    times = f"{1e3 * np.min(together, axis=0)[0]:9.2f} {1e3 * np.median(together, axis=0)[0]:9.2f}"
    row(
        f"two fits at once (alone: {1e3 * np.median(alone, axis=0)[0]:.1f} ms)",
        times,
        # on a machine with other work the first number tells of that work, the second of what the two share
        f"each loses {loss:.0f} % ({processor:.0f} % of processor time, load {os.getloadavg()[0]:.1f}); aim: 15 %",
    )
