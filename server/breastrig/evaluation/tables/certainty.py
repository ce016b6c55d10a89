"""How often the 90 % radii hold the true place, and how often right picks are doubted, as tables."""

from collections.abc import Sequence

from breastrig.evaluation.studies.result_cache import Record
from breastrig.evaluation.tables.accuracy import FAMILIES, of
from breastrig.evaluation.tables.table import Cell, Column, Row, Table

KINDS = {"exact": "exact picks", "clicked": "picks 5 mm off", "half": "half of them given"}
PARTS = {"landmarks": "landmark", "skin": "skin"}


def held(records: Sequence[Record], kind: str, part: str, place: str | None = None) -> tuple[int, int]:
    """How many true places the radii held, of how many; of all kinds of places when none is named."""
    counts = [
        count
        for record in records
        if not record.failed
        for name, count in record.answer.get(kind, {}).get(part, {}).items()
        if place in (None, name)
    ]
    return sum(count[0] for count in counts), sum(count[1] for count in counts)


def certainty_table(records: Sequence[Record]) -> Table:
    """One row a kind of place, percent held for each kind of picks; all families together, then each place."""
    columns = tuple(Column(kind, f"{words}: held %", 0) for kind, words in KINDS.items())
    caption = "Share of true places within their 90 % radius; n counts places over all fits."
    who = (Column("part", "of", key=True), Column("place", "place", key=True), Column("n", "n", 0))
    table = Table("certainty", caption, (*who, *columns))
    found = of(records, "certainty")
    for part, words in PARTS.items():
        kinds = {
            name: None
            for record in found
            if not record.failed
            for trial in record.answer.values()
            for name in trial[part]
        }
        for place in (None, *kinds):
            counts = [held(found, kind, part, place) for kind in KINDS]
            total = sum(count[1] for count in counts)
            if total:
                cells: list[Cell] = [100.0 * good / n if n else None for good, n in counts]
                table.rows.append(Row((words, place or "all", total, *cells)))
    return table


def believed_table(records: Sequence[Record]) -> Table:
    """Right picks that were let go or asked about, for each family and kind of picks."""
    columns = (Column("picks", "picks", 0), Column("dropped", "let go", 0), Column("unusual", "asked about", 0))
    who = (Column("family", "bodies", key=True), Column("kind", "picks", key=True))
    table = Table("believed", "Picks that are right, as the scan shows them.", (*who, *columns))
    found = of(records, "certainty")
    for family, words in FAMILIES.items():
        for kind, picks in KINDS.items():
            trials = [
                record.answer[kind]
                for record in found
                if record.case.family == family and not record.failed and kind in record.answer
            ]
            if trials:
                sums: list[Cell] = [sum(trial[column.name] for trial in trials) for column in columns]
                table.rows.append(Row((words, picks, *sums)))
    return table
