"""From the scan's file to all result files, in the program and from the shell, and what a pattern in mm adds."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.example_fit import EXAMPLE, indexed_scan

from breastrig.drawings.patterns import asked_drawing
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.use.fit import run_fit
from breastrig.use.steps.settings import FitJob

ROUNDS = 7
ITERATIONS = 10  # of the default preset on this scan, about


@pytest.mark.parametrize("given", ["landmarks", "nothing"])
@pytest.mark.parametrize("which", ["own", "finer"])
def test_whole_job(
    benchmark: Any,
    row: Callable[..., None],
    in_turn: Callable[..., Any],
    floor: Any,
    scan_50k: Path,
    tmp_path: Path,
    which: str,
    given: str,
) -> None:
    """The example's own scan of 61,784 triangles, and that of the other rows, whose breasts are tried as hanging.

    Without landmarks the scan has to show where she is, and whether she lies.
    """
    scan = EXAMPLE / "scan.ply" if which == "own" else scan_50k
    places, _ = read_landmarks(EXAMPLE / "landmarks.json")
    picks = {name: [float(x) for x in place] for name, place in places.items()} if given == "landmarks" else {}

    def kernels() -> None:
        indexed_scan(scan)
        for _ in range(ITERATIONS):
            floor()

    yardstick = in_turn(kernels)
    benchmark.pedantic(
        lambda: list(run_fit(FitJob(scan=scan, out=tmp_path / "out", landmarks_mm=picks))),
        setup=yardstick,
        rounds=ROUNDS,
        warmup_rounds=1,
    )
    share = yardstick.ratio(benchmark)
    row(
        f"whole job, {which} scan, {given} given",
        benchmark,
        f"{share:.2f} of indexing and {ITERATIONS} floors; aim: 2",
    )


@pytest.mark.parametrize("text", ["reduction", "tumour:L,10,45,12"])
def test_patterns(
    benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any], floor: Any, task: Any, text: str
) -> None:
    asked, yardstick = asked_drawing(task.rig, text), in_turn(floor, ITERATIONS)
    benchmark.pedantic(
        lambda: asked.on_model(task.rig, task.rig.template), setup=yardstick, rounds=ROUNDS, warmup_rounds=1
    )
    row(f"drawing {text.partition(':')[0]}", benchmark, f"{yardstick.ratio(benchmark):.2f} of {ITERATIONS} floors")


@pytest.mark.parametrize("words", ["fit --help", "fit SCAN -o OUT"])
def test_from_the_shell(
    benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any], scan_50k: Path, tmp_path: Path, words: str
) -> None:
    """A process counts by the clock on the wall only."""

    def python(*arguments: str) -> None:
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)

    command = words.replace("SCAN", str(scan_50k)).replace("OUT", str(tmp_path / "out")).split()
    empty = in_turn(lambda: python("-c", "import numpy"))
    benchmark.pedantic(
        lambda: python("-m", "breastrig.cli.entry", *command), setup=empty, rounds=ROUNDS, warmup_rounds=1
    )
    row(f"breastrig {words}", benchmark, f"{empty.ratio(benchmark):.2f} of python -c 'import numpy'")
