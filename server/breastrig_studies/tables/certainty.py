"""Tables of the coverage of 90 % radii, and of right picks that are doubted."""

from collections.abc import Sequence

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.transfer import ALL
from breastrig_studies.studies.trust.certainty import GIVEN, NOT_GIVEN, NOT_SEEN, SEEN
from breastrig_studies.studies.trust.reliability import LEVELS
from breastrig_studies.tables.accuracy import FAMILIES, of
from breastrig_studies.tables.table import Cell, Column, Row, Table

KINDS = {"exact": "exact picks", "clicked": "picks 5 mm off", "half": "half of them given"}
CARRIED = "carried lines"
GROUPS = (GIVEN, NOT_GIVEN, SEEN, NOT_SEEN, CARRIED)
TRANSFER_PICKS = {"exact": "true", "clicked": "5 mm off"}  # kind -> as the transfers call it
PARTS = {"landmarks": "landmark", "skin": "skin", "lines": "line"}


def covered(records: Sequence[Record], kind: str, part: str, place: str | None = None) -> tuple[int, int]:
    """The number of true places within the radii, and of all; over all kinds of places when none is named."""
    counts = [
        count
        for record in records
        if not record.failed
        for name, count in record.answer.get(kind, {}).get(part, {}).items()
        if place in (None, name)
    ]
    return sum(count[0] for count in counts), sum(count[1] for count in counts)


def certainty_table(records: Sequence[Record]) -> Table:
    """One row a kind of place, percent covered for each kind of picks; all families together, then each place."""
    columns = tuple(Column(kind, f"{words}: covered %", 0) for kind, words in KINDS.items())
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
            counts = [covered(found, kind, part, place) for kind in KINDS]
            total = sum(count[1] for count in counts)
            if total:
                cells: list[Cell] = [100.0 * good / n if n else None for good, n in counts]
                table.rows.append(Row((words, place or "all", total, *cells)))
    return table


def levels_covered(records: Sequence[Record], group: str, kind: str) -> list[int]:
    """The number of the group's true places within the radius of each of LEVELS, and of all, over all cases.

    `kind` is one of KINDS; transferred lines are searched in the transfers, where they were made with such picks.
    """
    if group == CARRIED:
        counts = [
            row["levels"]
            for record in of(records, "transfer")
            if not record.failed
            for row in record.answer["rows"]
            if (row["picks"], row["line"], row["region"]) == (TRANSFER_PICKS.get(kind), ALL, ALL) and "levels" in row
        ]
    else:
        counts = [
            record.answer[kind]["levels"][group]
            for record in of(records, "certainty")
            if not record.failed and group in record.answer.get(kind, {}).get("levels", {})
        ]
    return [sum(column) for column in zip(*counts, strict=True)] if counts else [0] * (len(LEVELS) + 1)


def reliability_table(records: Sequence[Record]) -> Table:
    """One row a group of places and kind of picks: percent covered by the radius of each level."""
    caption = "Share of true places within the radius of each level; a sure program holds what it says."
    who = (Column("group", "of", key=True), Column("kind", "picks", key=True), Column("n", "n", 0))
    columns = tuple(Column(f"held_{100 * level:.0f}", f"{100 * level:.0f} %", 0) for level in LEVELS)
    table = Table("reliability", caption, (*who, *columns))
    for group in GROUPS:
        for kind, words in KINDS.items():
            *good, total = levels_covered(records, group, kind)
            if total:
                cells: list[Cell] = [100.0 * each / total for each in good]
                table.rows.append(Row((group, words, total, *cells)))
    return table


def believed_table(records: Sequence[Record]) -> Table:
    """Right picks that were rejected or asked about, for each family and kind of picks."""
    columns = (Column("picks", "picks", 0), Column("dropped", "rejected", 0), Column("unusual", "asked about", 0))
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
