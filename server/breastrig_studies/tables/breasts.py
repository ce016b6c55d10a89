"""Tables split by whether the bodies' breasts hang: all bodies first, as without them, then these and the others.

Hanging breasts are where a fit's landmarks, its doubts and what it says of itself are worst, and a quarter of a mixed
family of bodies hides that.  Where nobody says whether breasts hang a table stays as it is.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.table import Column, Row, Table

BREASTS = Column("breasts", "breasts", key=True)
ALL = "all"
PARTS = {True: "hanging", False: "not hanging"}


def by_breasts(table: Callable[[Sequence[Record]], Table], records: Sequence[Record], *, means: bool = False) -> Table:
    """The table of all records with a first column `breasts`, and below it those of hanging and of other breasts.

    With `means` only the mean rows of these two, where each case has a row of its own already.
    """
    whole = table(records)
    if all(record.case.hanging is None for record in records):
        return whole
    rows = [_named(ALL, row) for row in whole.rows]
    for hanging, words in PARTS.items():
        part = table([record for record in records if record.case.hanging is hanging])
        rows += [_named(words, row) for row in part.rows if row.mean or not means]
    return replace(whole, columns=(BREASTS, *whole.columns), rows=rows)


def of_all(table: Table) -> Table:
    """The table as it was before it was split."""
    if BREASTS not in table.columns:
        return table
    rows = [replace(row, cells=row.cells[1:]) for row in table.rows if row.cells[0] == ALL]
    return replace(table, columns=table.columns[1:], rows=rows)


def _named(words: str, row: Row) -> Row:
    return replace(row, cells=(words, *row.cells))
