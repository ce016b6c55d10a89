"""The table of measures: its rows, their changes between two stances, and their numbers in files and in print.

The same rows are in report.json, measures.csv and the PDF.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.documents import csv_table

Lines = dict[str, list[list[float]]]
Cell = str | float | Lines | None
COLUMNS = (
    "stance", "measure", "kind", "unit",
    "left", "left_low", "left_high", "right", "right_low", "right_high", "difference",
    "value", "value_low", "value_high",
    "landmarks", "method",
)  # fmt: skip
VERDICT = "verdict"  # the last column
LEVELS = ("", "good", "uncalibrated", "check", "unusable")  # of a verdict; none in results of earlier versions
PATH_DIGITS = 1  # of mm, in the lines that were measured: they are looked at, not measured again
FILE_DIGITS = {"mm": 2, "ml": 1, "1": 4, "grade": 0}  # a hundredth of a millimetre is below any scanner: enough
# In print, where nothing is known of a band, and the coarsest.
STEPS = {"mm": (0.1, 1.0), "ml": (1.0, 10.0), "1": (0.01, 0.1)}
GRADES = ("none", "I", "II", "III", "glandular")  # of ptosis.py


@dataclass(frozen=True)
class Value:
    """One number, in the row's unit, with its band where one is known."""

    value: float
    low: float | None = None
    high: float | None = None

    @property
    def margin(self) -> float | None:
        """The larger side of the band; None where none is known."""
        if self.low is None or self.high is None:
            return None
        return max(self.high - self.value, self.value - self.low)


@dataclass(frozen=True)
class Row:
    """One measure of one stance; sided, or one value for both breasts."""

    measure: str  # name for programs
    label: str  # for people
    kind: str  # straight | along the skin | in height | ratio | volume | grade
    unit: str  # mm | ml | 1 | grade
    left: Value | None
    right: Value | None
    value: Value | None
    landmarks: tuple[str, ...]  # each with its source: picked, seen, or model
    method: str
    paths: Mapping[str, Array] = field(default_factory=dict)  # left, right or value: (M, 3) m, what was measured

    @property
    def difference(self) -> float | None:
        """Left less right; grades are no numbers to be subtracted."""
        if self.left is None or self.right is None or self.unit == "grade":
            return None
        return self.left.value - self.right.value


def flat_rows(stances: Sequence[tuple[str, Sequence[Row]]]) -> list[dict[str, Cell]]:
    """The rows of one or two (name, rows); of two also their changes, the second less the first.

    `paths` are lines in the scan's frame, mm; a change has none.
    """
    flat = [_flat(name, row) for name, rows in stances for row in rows]
    if len(stances) == 2:
        (first, before), (second, after) = stances
        flat += [_flat(f"{second} - {first}", row) for row in changes(before, after)]
    return flat


def less(x: Value | None, y: Value | None) -> Value | None:
    """y less x, whose errors are independent: their margins add up as squares."""
    if x is None or y is None:
        return None
    change = y.value - x.value
    if x.margin is None or y.margin is None:
        return Value(change)
    half = float(np.hypot(x.margin, y.margin))
    return Value(change, change - half, change + half)


def contradictions(stances: Sequence[tuple[str, Sequence[Row]]]) -> tuple[str, ...]:
    """Volumes of one breast in two (name, rows) that differ by more than their bands together."""
    if len(stances) != 2:
        return ()
    (first, before), (second, after) = stances
    known = {row.measure: row for row in before if row.kind == "volume"}
    found = []
    for row in (row for row in after if row.kind == "volume" and row.measure in known):
        for side in ("left", "right"):
            one, other = getattr(known[row.measure], side), getattr(row, side)
            change = less(one, other)
            if change is not None and change.margin is not None and abs(change.value) > change.margin:
                found.append(
                    f"The {side} breast measures {with_margin(one, 'ml')} ml {first} and {with_margin(other, 'ml')} ml "
                    f"{second}: one breast differs by less, nine times of ten; check both fits."
                )
    return tuple(found)


def changes(before: Sequence[Row], after: Sequence[Row]) -> list[Row]:
    """The measures that both stances have, after less before; grades are no numbers to be subtracted."""
    known = {(row.measure, row.kind): row for row in before if row.unit != "grade"}
    return [_change(known[row.measure, row.kind], row) for row in after if (row.measure, row.kind) in known]


def _change(a: Row, b: Row) -> Row:
    landmarks = tuple(dict.fromkeys((*a.landmarks, *b.landmarks)))
    left, right, value = (less(*pair) for pair in ((a.left, b.left), (a.right, b.right), (a.value, b.value)))
    return replace(a, left=left, right=right, value=value, landmarks=landmarks, paths={})


def _flat(stance: str, row: Row) -> dict[str, Cell]:
    digits = FILE_DIGITS[row.unit]

    def cut(number: float | None) -> float | None:
        return None if number is None else round(float(number), digits) + 0.0  # no minus zero

    cells: dict[str, Cell] = {"stance": stance, "measure": row.measure, "label": row.label}
    cells |= {"kind": row.kind, "unit": row.unit}
    for side, value in (("left", row.left), ("right", row.right), ("value", row.value)):
        cells[side] = cut(value.value) if value else None
        cells[f"{side}_low"] = cut(value.low) if value else None
        cells[f"{side}_high"] = cut(value.high) if value else None
    cells["difference"] = cut(row.difference)
    paths = {side: np.round(1e3 * line, PATH_DIGITS).tolist() for side, line in row.paths.items()}
    return cells | {"landmarks": "; ".join(row.landmarks), "method": row.method, "paths": paths or None}


def csv_bytes(rows: Sequence[dict[str, Cell]], verdicts: Mapping[str, str]) -> bytes:
    """The rows as CSV with a header; empty cells where a row has no such number.  A table has no room for lines.

    `verdicts`: the level of each stance's fit, repeated in its rows, for a table is read without its report; a
    change is as good as the worse of both.
    """
    worst = max(verdicts.values(), key=LEVELS.index, default="")
    return csv_table((*COLUMNS, VERDICT), [{**row, VERDICT: verdicts.get(str(row["stance"]), worst)} for row in rows])


def number(value: Value | None, unit: str, *, signed: bool = False) -> str:
    """The value without its unit, as finely as its band allows; a dash where there is none."""
    if value is None:
        return "-"
    if unit == "grade":
        return GRADES[round(value.value)]
    text = _rounded(value.value, _step(value.margin, unit), "+" if signed else "")
    return text if float(text) else text.lstrip("+-")


def _step(margin: float | None, unit: str) -> float:
    """In which steps a number is written: no finer than a tenth of its band of nine of ten true values."""
    least, most = STEPS[unit]
    return least if not margin else float(np.clip(10.0 ** np.floor(np.log10(0.5 * margin)), least, most))


def _rounded(number: float, step: float, sign: str = "") -> str:
    return f"{round(number / step) * step:{sign}.{max(0, round(-np.log10(step)))}f}"


def with_band(value: Value | None, unit: str) -> str:
    """290 (240 to 330)."""
    if value is None or value.low is None or value.high is None:
        return number(value, unit)
    if unit == "grade":
        low, high = (GRADES[round(end)] for end in (value.low, value.high))
        return number(value, unit) if low == high else f"{number(value, unit)}  ({low} to {high})"
    step = _step(value.margin, unit)
    return f"{number(value, unit)}  ({_rounded(value.low, step)} to {_rounded(value.high, step)})"


def with_margin(value: Value | None, unit: str, signed: bool = False) -> str:
    """201 ±4: the larger side of its band, both as finely as that allows; of a ratio 0.98 ±0.05."""
    text = number(value, unit, signed=signed)
    if value is None or value.margin is None or unit == "grade":
        return text
    return f"{text} ±{_rounded(value.margin, _step(value.margin, unit))}"
