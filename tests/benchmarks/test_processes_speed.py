"""What processes cost: a command's imports, the start of the server, many fits at once, and memory after many."""

import csv
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import numpy as np
from helpers.example_fit import EXAMPLE

ROUNDS = 5
WORKERS = 2
FITS = int(os.environ.get("BREASTRIG_FITS", "300"))
ONE_BY_ONE = """
import sys
from pathlib import Path
from threadpoolctl import threadpool_limits
from breastrig.use.steps.settings import FitJob
from breastrig.use.fit import run_fit

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6

with threadpool_limits(limits=1):
    for number in range(int(sys.argv[3])):
        list(run_fit(FitJob(Path(sys.argv[1]), Path(sys.argv[2]), {})))
        print(resident(), flush=True)
"""


def of_children() -> float:
    """s of the processor that ended children have taken."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def seconds(run: Callable[[], None]) -> float:
    began = of_children()
    run()
    return of_children() - began


def python(*words: str) -> None:
    subprocess.run([sys.executable, *words], check=True, capture_output=True)


def of_numpy(measure: Callable[[], float]) -> str:
    """Median of processor time, and its ratio to the import of NumPy measured in turn."""
    pairs = [(measure(), seconds(lambda: python("-c", "import numpy"))) for _ in range(ROUNDS)]
    own, numpy = np.array(pairs).T
    return f"{1e3 * np.median(own):.0f} ms of the processor, {np.median(own / numpy):.1f} of python -c 'import numpy'"


def test_imports_of_a_fit(benchmark: Any, row: Callable[..., None]) -> None:
    benchmark.pedantic(lambda: python("-c", "import breastrig.cli.fit_command"), rounds=ROUNDS, warmup_rounds=1)
    words = of_numpy(lambda: seconds(lambda: python("-c", "import breastrig.cli.fit_command")))
    row("imports of `breastrig fit`", benchmark, words)


def start_and_stop(folder: Path) -> None:
    command = [sys.executable, "-m", "breastrig.cli.entry", "serve", "--port", "0", "--data", str(folder)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert server.stdout is not None
    found = next(match for line in server.stdout if (match := re.search(r"http://[\d.]+:\d+", line)))
    urlopen(f"{found[0]}/healthz", timeout=30).close()
    server.terminate()
    server.communicate(timeout=30)


def test_start_of_the_server(benchmark: Any, row: Callable[..., None], tmp_path: Path) -> None:
    """Of all its processes: the server, the fork server and the first worker."""
    folders = iter(tmp_path / str(number) for number in range(100))
    benchmark.pedantic(lambda: start_and_stop(next(folders)), rounds=ROUNDS, warmup_rounds=1)
    row("start of `breastrig serve`", benchmark, of_numpy(lambda: seconds(lambda: start_and_stop(next(folders)))))


def test_batch(benchmark: Any, row: Callable[..., None], tmp_path: Path) -> None:
    """From 12 scans of the example patient, each with landmarks, to all result files."""
    manifest, count = tmp_path / "manifest.csv", 12
    with manifest.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["name", "scan", "landmarks"])
        for number in range(count):
            folder = EXAMPLE.with_name(("standing", "supine")[number % 2])
            table.writerow([f"fit-{number}", folder / "scan.ply", folder / "landmarks.json"])
    outputs = iter(tmp_path / str(number) for number in range(100))

    def batch() -> None:
        python("-m", "breastrig.cli.entry", "batch", str(manifest), "--jobs", str(WORKERS), "-o", str(next(outputs)))

    taken = []

    def timed() -> None:
        began = time.perf_counter()  # processes count by the clock on the wall only
        batch()
        taken.append(time.perf_counter() - began)

    benchmark.pedantic(timed, rounds=3, warmup_rounds=0)
    rate = count / float(np.median(taken))
    row(f"batch of {count} fits, {WORKERS} workers", benchmark, f"{rate:.1f} fits a second, its start included; aim: 6")


def test_memory_stays(benchmark: Any, row: Callable[..., None], tmp_path: Path) -> None:
    """Of one process that fits one scan after the other, as programs do; the service gives each fit a new process."""
    words = [sys.executable, "-c", ONE_BY_ONE, str(EXAMPLE / "scan.ply"), str(tmp_path / "out"), str(FITS)]

    def fits() -> list[float]:
        return [
            float(line) for line in subprocess.run(words, check=True, capture_output=True, text=True).stdout.split()
        ]

    megabytes = np.array(benchmark.pedantic(fits, rounds=1, warmup_rounds=0))
    early, late = np.median(megabytes[FITS // 10 : FITS // 5]), np.median(megabytes[-FITS // 10 :])
    assert late < 1.05 * early
    row(f"{FITS} fits in one process", benchmark, f"memory {early:.0f} MB after a tenth, {late:.0f} MB at the end")
