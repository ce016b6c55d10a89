"""Fits of prone scans as a table."""

from collections.abc import Sequence

import numpy as np

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import FAMILIES, WHO, of
from breastrig_studies.tables.table import Column, Row, Table

KINDS = {"given": "given", "half": "half given", "none": "none given", "head_down": "head down"}
LEVELS = ("good", "check", "unusable")
MEASURED = {"surface_mm": "surface", "nipples_mm": "nipples", "error_mm": "landmarks"}


def prone_table(records: Sequence[Record]) -> Table:
    """One row a family and kind of fit: medians and worst in mm, percent at each level and of stances found."""
    caption = (
        "Prone scans by the landmarks that were given: medians and worst, mm, of the model without its skin layer."
    )
    numbers = [
        column
        for name, words in MEASURED.items()
        for column in (Column(name, f"{words} mm"), Column(name.replace("_mm", "_worst_mm"), "worst"))
    ]
    levels = [Column(level, f"{level} %", 0) for level in LEVELS]
    fit = Column("fit", "landmarks", key=True)
    table = Table(
        "prone", caption, (WHO[0], fit, Column("n", "n", 0), *numbers, *levels, Column("found", "called prone %", 0))
    )
    for family, word in FAMILIES.items():
        answers = [r.answer for r in of(records, "prone") if r.case.family == family and not r.failed]
        for kind, words in KINDS.items():
            fits = [answer["fits"][kind] for answer in answers]
            if not fits:
                continue
            cells: list[float | None] = []
            for name in MEASURED:
                known = [fit[name] for fit in fits if fit[name] is not None]
                cells += [float(np.median(known)), float(max(known))] if known else [None, None]
            shares = [100.0 * sum(fit["level"] == level for fit in fits) / len(fits) for level in LEVELS]
            called = 100.0 * sum(answer["stance"] == "prone" for answer in answers) / len(answers)
            table.rows.append(Row((word, words, len(fits), *cells, *shares, called)))
    return table
