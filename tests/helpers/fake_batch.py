"""A fit for tests of batches: the scan's text says what becomes of it.  Also `breastrig batch` as a program with it.

fine              done at once; also "fine 7", "fine 8", ... for scans that differ
slow SECONDS      done after a while
fail | bug | die | greedy      as the fits of fake_fit
"""

import csv
import hashlib
import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from breastrig.cli import batch_command
from breastrig.cli.main import main
from breastrig.core.errors import FitFailed
from breastrig.files.result import ResultFile
from breastrig.use.steps.events import Done, Event
from breastrig.use.steps.settings import FitJob
from helpers.results import result_document

FILES = (
    "result.json",
    "scan.ply",
    "fitted.ply",
    "fitted.glb",
    "drawing.json",
    "distances.bin",
    "uncertainty.bin",
    "body.bin",
    "checks.bin",
    "fit.log.jsonl",
    "measures.csv",
)
WHOLE = {*FILES, "inputs.json"}


def scripted_fit(job: FitJob) -> Iterator[Event]:
    began = time.perf_counter()
    content = job.scan.read_text()
    word, *rest = content.split()
    if word == "slow":
        time.sleep(float(rest[0]))
    elif word == "fail":
        raise FitFailed("The model found no skin near it; place three landmarks.")
    elif word == "bug":
        raise ZeroDivisionError("an error of ours")
    elif word == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    elif word == "greedy":
        bytearray(2**45)
    result = result_of(content) | {
        "stance": "standing" if job.stance == "auto" else job.stance,
        "preset": job.preset,
        "refined": job.refine,
        "landmarks_given": job.landmarks_mm,
        "timing_s": {"solve": time.perf_counter() - began, "total": time.perf_counter() - began},
    }
    job.out.mkdir()
    for name in FILES:
        (job.out / name).write_text(json.dumps(result) if name == "result.json" else f"{name} of {content}")
    yield Done(result=ResultFile.model_validate(result))


def result_of(content: str) -> dict[str, object]:
    """Numbers that the scan's content alone decides."""
    mean = int.from_bytes(hashlib.sha256(content.encode()).digest()[:2], "big") / 65536
    distances = {"mean": mean, "std": mean / 2, "max": 5 * mean, "p95": 2 * mean, "coverage": 0.8}
    return result_document(scan={"triangles": len(content)}, iterations=9, surface_distance_mm=distances)


def write_manifest(folder: Path, scans: dict[str, str]) -> Path:
    """A scan of that content for each name, and the table of them."""
    lines = ["name,scan"]
    for name, content in scans.items():
        (folder / f"{name}.ply").write_text(content)
        lines.append(f"{name},{name}.ply")
    (folder / "manifest.csv").write_text("\n".join(lines) + "\n")
    return folder / "manifest.csv"


def table(out: Path) -> list[dict[str, str]]:
    """batch.csv"""
    with (out / "batch.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def whole_results(out: Path) -> set[str]:
    """Names of the results; each must have all its files."""
    names = {entry.name for entry in out.iterdir() if entry.is_dir() and not entry.name.startswith(".")}
    for name in names:
        assert {file.name for file in (out / name).iterdir()} == WHOLE
    return names


if __name__ == "__main__":
    from helpers import fake_batch

    batch_command.measured_fit = fake_batch.scripted_fit  # by the name that workers import
    sys.exit(main(["batch", *sys.argv[1:]]))
