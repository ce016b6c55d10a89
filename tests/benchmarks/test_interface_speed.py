"""Time of `import breastrig`, and what the Python interface adds to a fit."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from helpers.example_fit import EXAMPLE

import breastrig
from breastrig.core.clock import Clock
from breastrig.use.fit import fit_steps
from breastrig.use.steps.prepare import fit_plan, prepare_fit, scan_of_job
from breastrig.use.steps.settings import FitJob

ROUNDS = 9


def python(*words: str) -> None:
    """A Python of its own."""
    subprocess.run([sys.executable, *words], check=True)


def test_import(benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any]) -> None:
    """A process counts by the clock on the wall only."""
    empty = in_turn(lambda: python("-c", "pass"))
    benchmark.pedantic(lambda: python("-c", "import breastrig"), setup=empty, rounds=ROUNDS, warmup_rounds=1)
    row("python -c 'import breastrig'", benchmark, f"{empty.ratio(benchmark):.2f} of python -c pass")


def test_fit_from_a_program(
    benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any], tmp_path: Path
) -> None:
    """Without files: what a Fit costs beside the work on it."""
    model, scan = breastrig.load_model(), breastrig.read_scan(EXAMPLE / "scan.ply")
    job = FitJob(EXAMPLE / "scan.ply", tmp_path, {}, drawing=None)
    inner = scan_of_job(job)

    def bare() -> Any:
        clock = Clock()
        *_, outcome = fit_steps(prepare_fit(fit_plan(job, model, {}), inner, clock), clock)
        return outcome

    yardstick = in_turn(bare)
    fit = benchmark.pedantic(
        lambda: breastrig.fit(scan, drawing=None, model=model), setup=yardstick, rounds=ROUNDS, warmup_rounds=1
    )
    assert fit.verdict.level in ("good", "check")
    row("breastrig.fit of a scan that was read", benchmark, f"{yardstick.ratio(benchmark):.2f} of the work below it")
