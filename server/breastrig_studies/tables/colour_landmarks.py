"""Tables from records: landmarks proposed with the scan's colours and without, and the areolae's diameters."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from breastrig.core.stances import split_side
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of
from breastrig_studies.tables.table import Column, Row, Table

QUESTION = "colour_landmarks"
ALL = "all"


def colour_landmarks_table(records: Sequence[Record]) -> Table:
    """One row a landmark, both sides together, then nipples by whether they are natural, then all landmarks."""
    caption = (
        "Landmarks proposed on coloured scans, none given: mean distance to the true place by the form alone and with "
        "the colours, mm; 95 %: of these the 95th percentile; seen: share found by colour; held: share within the "
        "error that is given (90 % is meant); exchanged: scans on which a nipple lies nearer to the other side's place."
    )
    columns = (
        Column("landmark", "landmark", key=True),
        *(Column("number", "number", 0), Column("form_mm", "form"), Column("coloured_mm", "with colour")),
        *(
            Column("p95_mm", "95 %"),
            Column("seen", "seen"),
            Column("held", "held"),
            Column("exchanged", "exchanged", 0),
        ),
    )
    table = Table("colour_landmarks", caption, columns)
    answers = [record.answer for record in of(records, QUESTION) if not record.failed]
    if not answers:
        return table
    kinds = list(dict.fromkeys(split_side(name)[0] for answer in answers for name in answer["coloured"]))
    swaps = sum(1 for answer in answers if answer["exchanged"])
    for kind in kinds:
        rows = [row for row in _rows(answers) if row["kind"] == kind]
        table.rows.append(_row(kind.replace("_", " "), rows, swaps if kind == "nipple" else None))
    for state in sorted({row["state"] for row in _rows(answers)} - {""}):
        rows = [row for row in _rows(answers) if row["state"] == state]
        table.rows.append(_row(f"nipple, {state}", rows, None))
    everything = _row(ALL, list(_rows(answers)), None)
    table.rows.append(Row(everything.cells, mean=True))
    return table


def areolae_table(records: Sequence[Record]) -> Table:
    """Errors of measured diameters of areolae."""
    caption = (
        "Diameters of areolae by the border of their colour, mm: number with a true border, share seen, mean error "
        "(above zero: too large), standard deviation, and the share of true diameters within the band (90 % is meant)."
    )
    columns = (
        *(Column("stance", "stance", key=True), Column("number", "number", 0), Column("seen", "seen")),
        *(Column("bias_mm", "bias"), Column("deviation_mm", "deviation"), Column("held", "held")),
    )
    table = Table("areolae", caption, columns)
    entries = [
        (record.case.stance, each)
        for record in of(records, QUESTION)
        if not record.failed
        for each in record.answer["areolae"].values()
    ]
    for stance in (*sorted({stance for stance, _ in entries}), *([ALL] if entries else [])):
        own = [each for other, each in entries if stance in (other, ALL)]
        seen = [each for each in own if each["found_mm"] is not None]
        errors = np.array([each["found_mm"] - each["true_mm"] for each in seen])
        within = np.array([each["within_mm"] for each in seen])
        numbers = (
            (float(errors.mean()), float(errors.std()), float((np.abs(errors) <= within).mean()))
            if len(seen)
            else (None, None, None)
        )
        table.rows.append(Row((stance, len(own), len(seen) / len(own), *numbers), mean=stance == ALL))
    return table


def console(records: Sequence[Record]) -> str:
    """Both tables for a terminal; empty when no scan has colours."""
    lines = []
    for table in (colour_landmarks_table(records), areolae_table(records)):
        if table.rows:
            widths = [24, *[12] * (len(table.columns) - 1)]
            lines.append("".join(f"{c.heading:>{w}s}" for c, w in zip(table.columns, widths, strict=True)))
            for row in table.rows:
                cells = zip(table.shown(row), widths, strict=True)
                lines.append("".join(f"{text:>{width}s}" for (text, _), width in cells))
    return "\n".join(lines)


def _rows(answers: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry a landmark of a scan."""
    return [
        {
            "kind": split_side(name)[0],
            "form": answer["form"][name],
            "coloured": gap,
            "seen": name in answer["seen"],
            "held": answer["held"][name],
            "state": answer["states"].get(name, ""),
        }
        for answer in answers
        for name, gap in answer["coloured"].items()
    ]


def _row(label: str, rows: Sequence[dict[str, Any]], exchanged: int | None) -> Row:
    gaps = np.array([row["coloured"] for row in rows])
    held = [row["held"] for row in rows if row["held"] is not None]
    cells = (
        *(label, len(rows), float(np.mean([row["form"] for row in rows])), float(gaps.mean())),
        *(float(np.percentile(gaps, 95)), float(np.mean([row["seen"] for row in rows]))),
        *(float(np.mean(held)) if held else None, exchanged),
    )
    return Row(cells)
