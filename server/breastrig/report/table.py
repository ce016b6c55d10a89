"""The measures of one or two stances as flat rows: the same in report.json and measures.csv."""

import csv
import io
from collections.abc import Sequence

from breastrig.report.row import Row, Value

Cell = str | float | None
COLUMNS = (
    "stance", "measure", "kind", "unit",
    "left", "left_low", "left_high", "right", "right_low", "right_high", "difference", "value",
    "landmarks", "method",
)  # fmt: skip
DIGITS = {"mm": 2, "ml": 1, "1": 4}  # a hundredth of a millimetre is below any scanner: enough


def flat_rows(stances: Sequence[tuple[str, Sequence[Row]]]) -> list[dict[str, Cell]]:
    """The rows of one or two (name, rows); of two also their changes, the second less the first."""
    flat = [_flat(name, row) for name, rows in stances for row in rows]
    if len(stances) == 2:
        (first, before), (second, after) = stances
        flat += [_flat(f"{second} - {first}", row) for row in changes(before, after)]
    return flat


def changes(before: Sequence[Row], after: Sequence[Row]) -> list[Row]:
    """The measures that both stances have, after less before."""
    known = {(row.measure, row.kind): row for row in before}
    return [_change(known[row.measure, row.kind], row) for row in after if (row.measure, row.kind) in known]


def _change(a: Row, b: Row) -> Row:
    def less(x: Value | None, y: Value | None) -> Value | None:
        return None if x is None or y is None else Value(y.value - x.value)

    landmarks = tuple(dict.fromkeys((*a.landmarks, *b.landmarks)))
    return Row(
        a.measure,
        a.label,
        a.kind,
        a.unit,
        less(a.left, b.left),
        less(a.right, b.right),
        less(a.value, b.value),
        landmarks,
        a.method,
    )


def _flat(stance: str, row: Row) -> dict[str, Cell]:
    digits = DIGITS[row.unit]

    def cut(number: float | None) -> float | None:
        return None if number is None else round(float(number), digits) + 0.0  # no minus zero

    cells: dict[str, Cell] = {"stance": stance, "measure": row.measure, "kind": row.kind, "unit": row.unit}
    for side, value in (("left", row.left), ("right", row.right)):
        cells[side] = cut(value.value) if value else None
        cells[f"{side}_low"] = cut(value.low) if value else None
        cells[f"{side}_high"] = cut(value.high) if value else None
    cells["difference"] = cut(row.difference)
    cells["value"] = cut(row.value.value) if row.value else None
    return cells | {"landmarks": "; ".join(row.landmarks), "method": row.method}


def csv_bytes(rows: Sequence[dict[str, Cell]]) -> bytes:
    """The rows as CSV with a header; empty cells where a row has no such number."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()
