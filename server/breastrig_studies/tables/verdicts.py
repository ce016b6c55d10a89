"""Table of verdicts: shares of right fits called good and of wrong ones that are not."""

from collections.abc import Sequence

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of
from breastrig_studies.tables.table import Column, Row, Table

KINDS = {
    "landmarks": "landmarks given",
    "none": "none given",
    "accepted": "proposals accepted",
    "head_down": "head down",
}
LEVELS = ("good", "check", "unusable")
RIGHT, WRONG = 20.0, 40.0  # mm of the true landmarks on average: up to the one a fit is right, beyond the other wrong


def verdicts_table(records: Sequence[Record]) -> Table:
    """One row a kind of fit, a scan's extent and what is true: how many, and percent at each level."""
    who = (
        Column("fit", "fit", key=True),
        Column("scan", "scan", key=True),
        Column("truth", "landmarks", key=True),
        Column("n", "n", 0),
    )
    columns = tuple(Column(level, f"{level} %", 0) for level in LEVELS)
    caption = (
        f"What is said of fits whose landmarks are right (to {RIGHT:.0f} mm), wrong (over {WRONG:.0f} mm) or between."
    )
    table = Table("verdicts", caption, (*who, *columns))
    found: dict[tuple[str, str, str], list[str]] = {}
    for record in of(records, "verdicts"):
        for kind, fit in {} if record.failed else record.answer["fits"].items():
            truth = "right" if fit["error_mm"] <= RIGHT else "wrong" if fit["error_mm"] > WRONG else "between"
            found.setdefault((kind, "whole" if record.answer["whole"] else "part", truth), []).append(fit["level"])
    for kind, words in KINDS.items():
        for extent in ("whole", "part"):
            for truth in ("right", "between", "wrong"):
                levels = found.get((kind, extent, truth), [])
                if levels:
                    shares = [100.0 * levels.count(level) / len(levels) for level in LEVELS]
                    table.rows.append(Row((words, extent, truth, len(levels), *shares)))
    return table
