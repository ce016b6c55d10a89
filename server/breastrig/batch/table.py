"""batch.csv: what became of each row, with the numbers of its result.json."""

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.private_files import write_private
from breastrig.workflow.folder.fit_file_names import DRAWING_MISSING

NUMBERS = {  # column -> its place in result.json
    "stance": ("stance",),
    "unit": ("scan", "unit"),
    "triangles": ("scan", "triangles"),
    "mean_mm": ("surface_distance_mm", "mean"),
    "std_mm": ("surface_distance_mm", "std"),
    "max_mm": ("surface_distance_mm", "max"),
    "p95_mm": ("surface_distance_mm", "p95"),
    "coverage": ("surface_distance_mm", "coverage"),
    "landmark_mean_mm": ("landmark_distance_mm", "mean"),
    "iterations": ("iterations",),
    "solve_s": ("timing_s", "solve"),
    "total_s": ("timing_s", "total"),
    "verdict": ("verdict", "level"),
    "model_alone_mean_mm": ("model_alone", "surface_distance_mm", "mean"),
}
BEFORE = {"verdict": {"level": None}, "model_alone": {"surface_distance_mm": {"mean": None}}}  # earlier results

TIMES = ("solve_s", "total_s")  # all other columns are the same wherever and however often a fit runs
FIRST = ("name", "state", "reason")
COLUMNS = (*FIRST, *NUMBERS, DRAWING_MISSING)
FILE = "batch.csv"


@dataclass(frozen=True)
class Outcome:
    """What became of one row."""

    name: str
    reason: str | None = None  # why it failed, one sentence; None: it is done
    numbers: Mapping[str, Any] = field(default_factory=dict)  # by column; None where there is no such number

    @property
    def state(self) -> str:
        return "done" if self.reason is None else "failed"

    @property
    def missing(self) -> str | None:
        """Why its drawing lacks what was asked for; None: it lacks nothing."""
        return self.numbers.get(DRAWING_MISSING)


def is_table(file: Path) -> bool:
    """Whether a batch wrote it: its first line names our columns, of this version or of one with fewer."""
    try:
        with file.open("rb") as stream:
            found = stream.readline(1000).decode("utf-8", "replace").rstrip("\r\n").split(",")
        return len(found) > len(FIRST) and tuple(found) == COLUMNS[: len(found)]
    except OSError:
        return False


def numbers_of(result: Mapping[str, Any]) -> dict[str, Any]:
    """The columns' values from a result.json.  Raises KeyError or TypeError when it is none."""
    numbers = {}
    for column, place in NUMBERS.items():
        value: Any = BEFORE | dict(result)
        for key in place:
            value = value[key]
        numbers[column] = value
    return numbers | {DRAWING_MISSING: " ".join(result.get(DRAWING_MISSING, ())) or None}


def write_table(outcomes: Iterable[Outcome], folder: Path) -> None:
    """Writes batch.csv, whole or not at all; a row for each outcome in their order."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for outcome in outcomes:
        writer.writerow({"name": outcome.name, "state": outcome.state, "reason": outcome.reason, **outcome.numbers})
    write_private(folder / FILE, text.getvalue().encode())
