"""This version against the commit that earlier_commit.txt names, in turn in the same run: processor seconds of both.

The commit is one whose times were known to be good; a later one takes its place when it is faster.  Skipped where the
history is not there, as in an unpacked archive.
"""

import os
import resource
import subprocess
import sys
import tarfile
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.example_fit import EXAMPLE

ROOT = Path(__file__).parents[2]
EARLIER = Path(__file__).with_name("earlier_commit.txt").read_text().strip()
ROUNDS, FITS = 3, 4
PICKS = EXAMPLE / "landmarks.json"
IN_MEMORY = f"""
import json, sys, time
from pathlib import Path
from threadpoolctl import threadpool_limits
{{imported}}
scan, picks, out = Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])
places = {{{{name: [float(x) for x in place] for name, place in json.loads(picks.read_text())["landmarks"].items()}}}}
with threadpool_limits(limits=1):
    taken = []
    for number in range({FITS}):
        began = time.process_time()
        {{fitted}}
        taken.append(time.process_time() - began)
print(min(taken[1:]))
"""
FIT = "fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(PICKS), "-o", "OUT", "--force"
PROGRAMS = {
    "import breastrig": ("-c", "import breastrig"),
    "import of a command": ("-c", "import breastrig.cli.fit_command"),
    "breastrig fit": ("-m", "breastrig.cli.entry", *FIT),
}
RUN_FIT = """
try:
    from breastrig.use.fit import run_fit
    from breastrig.use.steps.settings import FitJob, FitSettings
    asked = dict(settings=FitSettings())
except ImportError:  # as the earlier one calls them
    from breastrig.workflow.jobs import FitJob
    from breastrig.workflow.run_fit import run_fit
    asked = dict(units='auto', stance='auto', preset='default', preset_file=None, drawing='lumpectomy', refine=True)
"""
TASKS = {
    "from a program, with its files": IN_MEMORY.format(
        imported="import breastrig",
        fitted='breastrig.fit(scan, picks).save(out / f"{number}")',
    ),
    "whole job of a service or a batch": IN_MEMORY.format(
        imported=RUN_FIT,
        fitted="list(run_fit(FitJob(scan=scan, out=out, landmarks_mm=places)))",
    ),
    "row of a batch, with its measures": IN_MEMORY.format(
        imported=f"from breastrig.batch import task\n{RUN_FIT}\n"
        "runner = getattr(task, 'measured_fit', run_fit)  # the earlier one made no measures",
        fitted="task.fit_of_bytes(task.FitOfBytes(scan=scan.read_bytes(), ending='.ply', landmarks=picks.read_bytes(), "
        "landmarks_ending='.json', **asked), runner)",
    ),
}


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package as it was, unpacked."""
    folder = tmp_path_factory.mktemp("earlier")
    words = ["git", "-C", str(ROOT), "archive", "--format=tar", EARLIER, "server", "model_assets"]
    try:
        found = subprocess.run(words, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip(f"the commit {EARLIER[:12]} is not in this repository's history")
    with tarfile.open(fileobj=BytesIO(found.stdout)) as files:
        files.extractall(folder, filter="data")
    return folder / "server"


def python(package: Path, out: Path, *words: str) -> str:
    """What it prints; folders for a moment are beside `out`, where no other version removes them."""
    environment = os.environ | {"PYTHONPATH": str(package), "PYTHONDONTWRITEBYTECODE": "", "OPENBLAS_NUM_THREADS": "1"}
    environment |= {"TMPDIR": str(out.parent)}
    done = subprocess.run([sys.executable, *words], env=environment, capture_output=True, check=True, text=True)
    return done.stdout


def of_shell(package: Path, out: Path, words: Sequence[str]) -> float:
    """s of the processor that the words after `python` take, imports and all."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    python(package, out, *(word.replace("OUT", str(out)) for word in words))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize("what", [*PROGRAMS, *TASKS])
def test_against_an_earlier_commit(
    benchmark: Any, row: Callable[..., None], earlier: Path, tmp_path: Path, what: str
) -> None:
    def seconds(package: Path) -> float:
        out = tmp_path / package.parent.name
        if what not in TASKS:
            return of_shell(package, out, PROGRAMS[what])
        return float(python(package, out, "-c", TASKS[what], str(EXAMPLE / "scan.ply"), str(PICKS), str(out)))

    def in_turn() -> list[tuple[float, float]]:
        seconds(ROOT / "server"), seconds(earlier)  # compiled and in the system's cache from here on
        return [(seconds(ROOT / "server"), seconds(earlier)) for _ in range(ROUNDS)]

    now, then = np.array(benchmark.pedantic(in_turn, rounds=1)).T
    row(
        f"against {EARLIER[:8]}: {what}",
        f"{1e3 * now.min():9.2f} {1e3 * np.median(now):9.2f}",
        f"{np.median(now / then):.2f} of it; at most 1.1 is wanted",
    )
