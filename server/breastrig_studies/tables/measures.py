"""Table of the errors of the report's measures, and of the coverage of their bands."""

from collections.abc import Sequence

import numpy as np

from breastrig.report.table import GRADES
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of
from breastrig_studies.tables.table import Cell, Column, Row, Table

GRADE = "grade"  # unit of what is counted, not measured: ptosis_table
PICKS = {"exact": "exact picks", "clicked": "5 mm off", "none": "no picks"}


def measures_table(records: Sequence[Record]) -> Table:
    """One row a measure: its mean true value, and for each kind of picks bias, mean error and percent held."""
    who = (Column("measure", "measure", key=True), Column("kind", "kind", key=True), Column("unit", "unit", key=True))
    columns = [
        Column(f"{kind}_{name}", f"{words}: {said}", digits)
        for kind, words in PICKS.items()
        for name, said, digits in (("bias", "bias", 2), ("error", "mean error", 2), ("held", "in band %", 0))
    ]
    caption = "Measures of the report against those of the whole true surface; in band: share of true values."
    table = Table("measures", caption, (*who, Column("n", "n", 0), Column("true", "true", 2), *columns))
    answers = [record.answer for record in of(records, "measures") if not record.failed]
    rows = {kind: [row for answer in answers for row in answer.get(kind, [])] for kind in PICKS}
    for key in dict.fromkeys(tuple(row[:3]) for row in rows["exact"] if row[2] != GRADE):
        found = {kind: [row[3:] for row in rows[kind] if tuple(row[:3]) == key] for kind in PICKS}
        true = [row[0] for row in found["exact"]]
        cells: list[Cell] = [len(true), float(np.mean(true))]
        for kind in PICKS:
            errors = np.array([row[1] - row[0] for row in found[kind]])
            held = [low <= value <= high for value, _, low, high in found[kind] if low is not None]
            cells += [float(errors.mean()), float(np.abs(errors).mean())] if len(errors) else [None, None]
            cells.append(100.0 * float(np.mean(held)) if held else None)
        table.rows.append(Row((*key, *cells)))
    return table


def ptosis_table(records: Sequence[Record]) -> Table:
    """One row a kind of picks and true grade: percent found at each grade, and right or left open."""
    who = (Column("kind", "picks", key=True), Column("true", "true grade", key=True), Column("n", "n", 0))
    shares = (*(Column(f"found_{name}", f"{name} %", 0) for name in GRADES), Column("set", "in stated set %", 0))
    table = Table("ptosis", "Grades of ptosis found, of those that are true (standing breasts).", (*who, *shares))
    for kind, words in PICKS.items():
        graded = [
            row[3:]
            for record in of(records, "measures")
            if not record.failed
            for row in record.answer.get(kind, [])
            if row[2] == GRADE
        ]
        for grade, name in enumerate(GRADES):
            own = [row for row in graded if round(row[0]) == grade]
            if own:
                found = [100.0 * float(np.mean([round(row[1]) == each for row in own])) for each in range(len(GRADES))]
                stated = [row[1] == row[0] or (row[2] is not None and row[2] <= row[0] <= row[3]) for row in own]
                table.rows.append(Row((words, name, len(own), *found, 100.0 * float(np.mean(stated)))))
    return table
