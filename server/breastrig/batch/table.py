"""batch.csv: the outcome of each row, with the numbers of its result.json and of its measures.csv."""

import csv
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.documents import csv_table
from breastrig.core.private_files import write_private
from breastrig.files.result import ResultFile
from breastrig.scan.unscaled import UNKNOWN_SIZE

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
    "solve_s": ("timing_s", "solve"),  # all but the times are the same wherever and however often a fit runs
    "total_s": ("timing_s", "total"),
    "verdict": ("verdict", "level"),
    "model_alone_mean_mm": ("model_alone", "surface_distance_mm", "mean"),
}

MISSING = "drawing_missing"
SIZE = "size"  # the last column, where the size of a scan is not known
FIRST = ("name", "state", "reason")
COLUMNS = (*FIRST, *NUMBERS, MISSING)
FILE = "batch.csv"
MEASURES = "measures.csv"  # of each result, as `breastrig report` writes it
KINDS = {"straight": "straight_", "along the skin": "skin_", "in height": "height_"}  # other measures have one kind
HEAD_BYTES = 100_000  # of the first line, which names some hundred columns


@dataclass(frozen=True)
class Outcome:
    """The outcome of one row."""

    name: str
    reason: str | None = None  # why it failed, one sentence; None: it is done
    numbers: Mapping[str, Any] = field(default_factory=dict)  # by column; None where there is no such number

    @property
    def state(self) -> str:
        return "done" if self.reason is None else "failed"

    @property
    def missing(self) -> str | None:
        """The reason why its drawing is incomplete; None where it is complete."""
        return self.numbers.get(MISSING)


def is_table(file: Path) -> bool:
    """Whether a batch wrote it: its first line begins with the columns, or is one of an earlier version with fewer."""
    try:
        with file.open("rb") as stream:
            found = stream.readline(HEAD_BYTES).decode("utf-8", "replace").rstrip("\r\n").split(",")
        return len(found) > len(FIRST) and tuple(found[: len(COLUMNS)]) == COLUMNS[: len(found)]
    except OSError:
        return False


def numbers_of(result_json: bytes, measures_csv: bytes) -> dict[str, Any]:
    """The columns' values from the two files of a result.  Raises ValueError or KeyError for other files."""
    result = ResultFile.model_validate_json(result_json)
    numbers = {}
    for column, place in NUMBERS.items():
        value: Any = result
        for key in place:
            value = value[key] if isinstance(value, dict) else getattr(value, key, None)
        numbers[column] = value
    numbers[MISSING] = " ".join(result.drawing_missing) or None
    asked = {} if result.size_known else {SIZE: UNKNOWN_SIZE}
    return numbers | _measures(measures_csv) | asked


def _measures(measures_csv: bytes) -> dict[str, Any]:
    """Measures by column: notch_nipple_skin_left_mm, notch_nipple_skin_left_low_mm, ...: each with its band's ends."""
    numbers = {}
    for row in csv.DictReader(measures_csv.decode().splitlines()):
        unit = "" if row["unit"] in ("1", "grade") else f"_{row['unit']}"
        for cell in (f"{side}{end}" for side in ("left", "right", "value") for end in ("", "_low", "_high")):
            if row[cell]:
                numbers[f"{row['measure']}_{KINDS.get(row['kind'], '')}{cell}{unit}"] = float(row[cell])
    return numbers


def write_table(outcomes: Iterable[Outcome], folder: Path) -> None:
    """Writes batch.csv, whole or not at all; a row for each outcome in their order."""
    rows = [{"name": each.name, "state": each.state, "reason": each.reason, **each.numbers} for each in outcomes]
    columns = dict.fromkeys([*COLUMNS, *(name for row in rows for name in row)])
    write_private(folder / FILE, csv_table(list(columns), rows))
