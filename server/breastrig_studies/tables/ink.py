"""Tables from records: ink found on coloured scans, and transferred to the other stance.

For each patient the common factor of the thresholds is the one that is best for all other patients, so no number of a
row was chosen on it. Where only one patient is there, the factor is 1.
"""

from collections.abc import Sequence

from breastrig_studies.studies.ink import FACTORS
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of
from breastrig_studies.tables.table import Column, Row, Table, mean, mean_row

FALSE_LIMIT_MM = 30.0  # falsely drawn on a scan without ink; beyond it a factor is no choice
WHO = (Column("patient", "patient", key=True), Column("scan", "scan", key=True))
NUMBERS = (
    Column("true_mm", "ink, mm", 0),
    Column("recall", "recall"),
    Column("precision", "precision"),
    Column("off_mm", "off, mm"),
    Column("false_mm", "false, mm", 0),
    Column("lines", "lines", 0),
    Column("time_s", "time, s"),
    Column("factor", "factor"),
)


def ink_table(records: Sequence[Record]) -> Table:
    """One row for each scan, the mean over inked scans, and the sum of what was falsely found on the others."""
    caption = (
        "Lines of ink found on coloured scans. Recall: share of the true length with a found line within 3 mm; "
        "precision: share of the found length within 3 mm of ink; off: mean distance of what matches; false: found "
        "length that is no ink. Factor: of all thresholds, chosen on the other patients (leave one patient out)."
    )
    table = Table("ink", caption, (*WHO, *NUMBERS))
    found = of(records, "ink")
    inked: list[Row] = []
    for record in found:
        if record.failed:
            blank = [None] * len(NUMBERS)
            table.rows.append(Row((record.case.patient, record.case.name, *blank), note=record.failed))
            continue
        factor = chosen_factor([other for other in found if other.case.patient != record.case.patient])
        numbers = record.answer[f"{factor:g}"]
        cells = [numbers[column.name] for column in NUMBERS[:-1]]
        row = Row((record.case.patient, record.case.name, *cells, factor))
        table.rows.append(row)
        if numbers["true_mm"] > 0.0:
            inked.append(row)
    if inked:
        table.rows.append(mean_row(("mean", "with ink"), inked))
    return table


def chosen_factor(records: Sequence[Record]) -> float:
    """The factor with the largest mean of recall and precision that draws little on scans without ink."""
    known = [record.answer for record in records if not record.failed]
    if not known:
        return 1.0

    def worth(factor: float) -> tuple[bool, float, float]:
        numbers = [answer[f"{factor:g}"] for answer in known]
        allowed = all(each["false_mm"] <= FALSE_LIMIT_MM for each in numbers if each["true_mm"] == 0.0)
        shares = [each[name] or 0.0 for each in numbers if each["true_mm"] > 0.0 for name in ("recall", "precision")]
        return allowed, mean(shares) or 0.0, -abs(factor - 1.0)

    return max(FACTORS, key=worth)


def ink_transfer_table(records: Sequence[Record]) -> Table:
    """One row for each pair of scans."""
    caption = (
        "Ink found on the standing scan and carried to the lying one: mean distance to the same skin there, mm, and "
        "what the transfer makes of the true lines."
    )
    columns = (
        *(Column("patient", "patient", key=True), Column("from", "from", key=True), Column("to", "to", key=True)),
        *(Column("points", "points", 0), Column("found_mm", "found"), Column("true_mm", "true")),
        Column("more_mm", "difference"),
    )
    table = Table("ink_transfer", caption, columns)
    rows = []
    for record in of(records, "ink_transfer"):
        if record.failed:
            rows.append(Row((record.case.patient, "", "", None, None, None, None), note=record.failed))
        for row in record.answer.get("rows", []):
            if row["points"]:
                more = row["found_mm"] - row["true_mm"]
                who = (record.case.patient, row["from"], row["to"])
                rows.append(Row((*who, row["points"], row["found_mm"], row["true_mm"], more)))
    if rows:
        table.rows.extend([*rows, mean_row(("mean", "", ""), rows)])
    return table


def console(records: Sequence[Record]) -> str:
    """Both tables for a terminal; empty when no scan has colours."""
    lines = []
    for table in (ink_table(records), ink_transfer_table(records)):
        if table.rows:
            lines.append("".join(f"{column.heading:>12s}" for column in table.columns))
            lines += ["".join(f"{text:>12s}" for text, _ in table.shown(row)) for row in table.rows]
    return "\n".join(lines)
