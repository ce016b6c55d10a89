"""The table of measures: its rows, their changes between two stances, and their numbers in files and in print.

The same rows are in report.json, measures.csv and the PDF.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.documents import csv_table

Lines = dict[str, list[list[float]]]
Cell = str | float | Lines | dict[str, str] | None
COLUMNS = (
    "stance", "measure", "kind", "unit",
    "left", "left_low", "left_high", "right", "right_low", "right_high",
    "difference", "difference_low", "difference_high",
    "value", "value_low", "value_high", "not_seen", "not_known", "vague",
    "landmarks", "method",
)  # fmt: skip
VERDICT = "verdict"  # the last column
LEVELS = ("", "good", "uncalibrated", "check", "unusable")  # of a verdict; none in results of earlier versions
PATH_DIGITS = 1  # of mm, in the lines that were measured: they are looked at, not measured again
FILE_DIGITS = {"mm": 2, "ml": 1, "1": 4, "grade": 0}  # a hundredth of a millimetre is below any scanner: enough
# In print, where nothing is known of a band, and the coarsest.
STEPS = {"mm": (0.1, 1.0), "ml": (1.0, 10.0), "1": (0.01, 0.1)}
GRADES = ("none", "I", "II", "III", "glandular")  # of ptosis.py
KNOWN_MM = 60.0  # a larger band or radius is that of a breast or more: nothing is known
NOT_KNOWN = "not known"  # in print, of what a band would say nothing
VAGUE = 0.1  # of a number: the widest band with which a length or a volume is said
VAGUELY_KNOWN = "not known well enough"  # in print, of a number with a wider one
NOT_SEEN = "not seen"  # in print, where the scan does not show what would be measured


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

    def moved_to(self, value: float) -> "Value":
        """Another number with as wide a band."""
        low, high = (None if end is None else end + value - self.value for end in (self.low, self.high))
        return Value(value, low, high)


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
    not_seen: tuple[str, ...] = ()  # of left, right, value: those that have no number, as the scan does not show them
    not_known: tuple[str, ...] = ()  # of these and the difference: those of which the band would say nothing
    vague: tuple[str, ...] = ()  # likewise: those less sure than a tenth of themselves
    between: float | None = None  # half the band of the difference; None: both sides are wrong independently
    stances: float = 0.0  # correlation of its errors with those of the same row of another fit of the patient

    @property
    def key(self) -> tuple[str, str]:
        """The row's key, unique in a stance: most lengths are measured straight and along the skin."""
        return self.measure, self.kind

    def with_values(self, changed: Callable[[Value], Value | None]) -> "Row":
        """The row with each of its numbers changed."""
        left, right, value = (None if each is None else changed(each) for each in (self.left, self.right, self.value))
        return replace(self, left=left, right=right, value=value)

    @property
    def difference(self) -> Value | None:
        """Left minus right, with the errors that they do not share; grades are not subtracted."""
        if self.unit == "grade" or "difference" in self.not_known:
            return None
        found = less(self.right, self.left)
        if found is None or found.margin is None or self.between is None:
            return found
        return Value(found.value, found.value - self.between, found.value + self.between)


def with_vague(row: Row) -> Row:
    """The row that says which of its lengths or volumes are less sure than VAGUE of themselves.

    A difference is as sure as what it is made of.
    """
    if row.unit not in ("mm", "ml"):
        return row
    cells = {name: value for name in ("left", "right", "value") if (value := getattr(row, name)) is not None}
    found = tuple(name for name, value in cells.items() if (value.margin or 0.0) > VAGUE * abs(value.value))
    return replace(row, vague=(*found, "difference") if found and row.difference is not None else found)


def rounded_once(row: Row) -> Row:
    """The row with its numbers rounded as in files, so that differences and changes agree with the written ones."""
    digits = FILE_DIGITS[row.unit]

    def cut(value: Value) -> Value:
        low, high = (None if end is None else round(float(end), digits) for end in (value.low, value.high))
        return Value(round(float(value.value), digits), low, high)

    return row.with_values(cut)


def printed_step(rows: Sequence[Row]) -> float:
    """The printing step of one measure over all stances and sides, for its most certain number."""
    values = [value for row in rows for value in (row.left, row.right, row.value) if value is not None]
    if not values or rows[0].unit == "grade":
        return 1.0
    return min(_step(value.margin, rows[0].unit) for value in values)


def as_printed(row: Row, step: float) -> Row:
    """The row with its numbers as printed, so that differences and changes agree with those beside them."""
    return row.with_values(lambda value: value.moved_to(_in_steps(value.value, step)))


def flat_rows(stances: Sequence[tuple[str, Sequence[Row]]], is_change: bool = False) -> list[dict[str, Cell]]:
    """The rows of one or two (name, rows); of two also their changes, the second less the first.

    `paths` are lines in the scan's frame, mm; a change has none.  `said` has the numbers as they are printed, by cell.
    """
    written = [(name, [rounded_once(row) for row in rows]) for name, rows in stances]
    known = [(name, row) for name, rows in written for row in rows]
    steps = {key: printed_step([row for _, row in known if row.key == key]) for key in {row.key for _, row in known}}
    said = [_said(as_printed(row, steps[row.key]), steps[row.key], is_change=is_change) for _, row in known]
    if len(stances) == 2:
        (first, before), (second, after) = written
        known += [(f"{second} - {first}", row) for row in changes(before, after)]
        printed = changes(*([as_printed(row, steps[row.key]) for row in rows] for _, rows in written))
        said += [_said(row, steps[row.key], is_change=True) for row in printed]
    return [_flat(name, row, steps[row.key]) | {"said": each} for (name, row), each in zip(known, said, strict=True)]


def _said(row: Row, step: float, *, is_change: bool) -> dict[str, str]:
    cells = {name: getattr(row, name) for name in ("left", "right", "value", "difference")}
    return {
        name: with_margin(value, row.unit, step, is_change or name == "difference")
        for name, value in cells.items()
        if value is not None
    }


def less(x: Value | None, y: Value | None, correlation: float = 0.0) -> Value | None:
    """y minus x with this correlation of errors: with independent ones their margins add up as squares."""
    if x is None or y is None:
        return None
    change = y.value - x.value
    if x.margin is None or y.margin is None:
        return Value(change)
    a, b = x.margin, y.margin
    half = float(np.sqrt(max(a * a + b * b - 2.0 * correlation * a * b, 0.0)))
    return Value(change, change - half, change + half)


def says_nothing(difference: Value | None, row: Row, of: Sequence[Value | None]) -> bool:
    """Whether the band of a difference of two numbers is as large as the smaller of them, or as a breast.

    Heights are counted from the fold and may be zero: for them only the breast's size counts.
    """
    if difference is None or difference.margin is None:
        return False
    sizes = [] if row.kind == "in height" else [abs(each.value) for each in of if each is not None]
    return difference.margin >= min([*sizes, *([KNOWN_MM] if row.unit == "mm" else [])], default=np.inf)


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
    """The measures that both stances have, after minus before; grades are not subtracted."""
    known = {row.key: row for row in before if row.unit != "grade"}
    return [_change(known[row.key], row) for row in after if row.key in known]


def _change(a: Row, b: Row) -> Row:
    landmarks = tuple(dict.fromkeys((*a.landmarks, *b.landmarks)))
    pairs = {"left": (a.left, b.left), "right": (a.right, b.right), "value": (a.value, b.value)}
    found_changes = {name: less(*pair, min(a.stances, b.stances)) for name, pair in pairs.items()}
    gone = [name for name, change in found_changes.items() if says_nothing(change, a, pairs[name])]
    gone += ["difference"] if {"left", "right"} & {*gone} else []
    left, right, value = (None if name in gone else change for name, change in found_changes.items())
    not_seen = tuple(dict.fromkeys((*a.not_seen, *b.not_seen)))
    not_known = tuple(dict.fromkeys((*a.not_known, *b.not_known, *gone)))
    halves = [each.margin for each in (a.difference, b.difference) if each is not None and each.margin is not None]
    between = float(np.linalg.norm(halves)) if len(halves) == 2 else None  # differences of sides have little in common
    found = replace(a, left=left, right=right, value=value, landmarks=landmarks, paths={}, not_seen=not_seen, vague=())
    found = replace(found, not_known=not_known, between=between)
    if not (a.vague or b.vague):
        return found
    cells = (name for name in (*pairs, "difference") if getattr(found, name) is not None)
    return replace(found, vague=tuple(cells))


def _flat(stance: str, row: Row, step: float) -> dict[str, Cell]:
    digits = FILE_DIGITS[row.unit]

    def cut(number: float | None) -> float | None:
        return None if number is None else round(float(number), digits) + 0.0  # no minus zero

    cells: dict[str, Cell] = {"stance": stance, "measure": row.measure, "label": row.label}
    cells |= {"kind": row.kind, "unit": row.unit}
    numbers = {"left": row.left, "right": row.right, "value": row.value, "difference": row.difference}
    for side, value in numbers.items():
        cells[side] = cut(value.value) if value else None
        cells[f"{side}_low"] = cut(value.low) if value else None
        cells[f"{side}_high"] = cut(value.high) if value else None
    cells["not_seen"] = "; ".join(row.not_seen)
    cells["not_known"] = "; ".join(row.not_known)
    cells["vague"] = "; ".join(row.vague)
    cells["printed_step"] = step
    paths = {side: np.round(1e3 * line, PATH_DIGITS).tolist() for side, line in row.paths.items()}
    return cells | {"landmarks": "; ".join(row.landmarks), "method": row.method, "paths": paths or None}


def csv_bytes(rows: Sequence[dict[str, Cell]], verdicts: Mapping[str, str]) -> bytes:
    """The rows as CSV with a header; empty cells where a row has no such number.  A table has no room for lines.

    `verdicts`: the level of each stance's fit, repeated in its rows, for a table is read without its report; a
    change is as good as the worse of both.
    """
    worst = max(verdicts.values(), key=LEVELS.index, default="")
    return csv_table((*COLUMNS, VERDICT), [{**row, VERDICT: verdicts.get(str(row["stance"]), worst)} for row in rows])


def number(value: Value | None, unit: str, step: float, *, signed: bool = False) -> str:
    """The value without its unit, in steps of `step`; a dash where there is none."""
    if value is None:
        return "-"
    if unit == "grade":
        return GRADES[round(value.value)]
    text = _rounded(value.value, step, "+" if signed else "")
    return text if float(text) else text.lstrip("+-")


def _step(margin: float | None, unit: str) -> float:
    """The printing step of a number: no finer than a tenth of its 90 % band."""
    least, most = STEPS[unit]
    return least if not margin else float(np.clip(10.0 ** np.floor(np.log10(0.5 * margin)), least, most))


def _rounded(number: float, step: float, sign: str = "") -> str:
    return f"{_in_steps(number, step):{sign}.{max(0, round(-np.log10(step)))}f}"


def _in_steps(number: float, step: float) -> float:
    """The number rounded to steps, halves up, as on the page, which shows the same numbers."""
    return float(np.floor(number / step + 0.5) * step)


def grade_text(value: Value | None) -> str:
    """The grade as text: II (I to III)."""
    text = number(value, "grade", 1.0)
    if value is None or value.low is None or value.high is None:
        return text
    low, high = (GRADES[round(end)] for end in (value.low, value.high))
    return text if low == high else f"{text}  ({low} to {high})"


def with_margin(value: Value | None, unit: str, step: float | None = None, signed: bool = False) -> str:
    """201 ±4: the larger side of its band; of a ratio 0.98 ±0.05.  Without a step as finely as its own band allows."""
    own = 1.0 if value is None or unit == "grade" else _step(value.margin, unit)
    text = number(value, unit, own if step is None else step, signed=signed)
    if value is None or value.margin is None or unit == "grade":
        return text
    return f"{text} ±{_rounded(value.margin, own)}"
