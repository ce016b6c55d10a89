"""Speed of what comes before a fit: reading, cleaning and indexing a scan of 80,000 triangles."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from helpers.example_fit import indexed_scan

from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan

ROUNDS = 9


def test_read(benchmark: Any, row: Callable[..., None], scan_80k: Path) -> None:
    benchmark.pedantic(lambda: read_scan(scan_80k), rounds=ROUNDS, warmup_rounds=1)
    row(f"reading a scan of {len(read_scan(scan_80k).faces):,} triangles", benchmark)


def test_clean(benchmark: Any, row: Callable[..., None], scan_80k: Path) -> None:
    scan = read_scan(scan_80k)
    benchmark.pedantic(lambda: clean(scan), rounds=ROUNDS, warmup_rounds=1)
    row("cleaning it", benchmark)


def test_read_clean_and_index(benchmark: Any, row: Callable[..., None], scan_80k: Path) -> None:
    benchmark.pedantic(lambda: indexed_scan(scan_80k), rounds=ROUNDS, warmup_rounds=1)
    share = benchmark.stats.stats.median / 0.5
    row("reading, cleaning and indexing it", benchmark, f"{share:.2f} of the aim of 500 ms")
