"""The cut scans as a table."""

from collections.abc import Sequence

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.unseen import CUTS
from breastrig_studies.tables.accuracy import FAMILIES, PATIENT, WHO, groups, of
from breastrig_studies.tables.table import Column, Row, Table, mean_row

COLUMNS = (
    Column("kept", "scan left"),
    Column("smallest_scale", "smallest scale"),
    Column("largest_scale", "largest scale"),
    Column("volume", "volume"),
    Column("weights", "weights"),
    Column("moved_mm", "moved mm", 1),
    Column("most_moved_mm", "most moved mm", 0),
)
WORDS = {"navel": "above the navel", "nipples": "above the nipples", "half": "the left half"}


def unseen_table(records: Sequence[Record]) -> Table:
    """One row a case and cut, then the mean, for each family and setting."""
    caption = "The fit of a part as a share of the fit of the whole; moved: mean and largest distance of the skin."
    table = Table("unseen", caption, (*WHO, Column("part", "scan left", key=True), PATIENT, *COLUMNS))
    for family, setting, found in groups(of(records, "unseen")):
        for cut in CUTS:
            rows = []
            for record in found:
                numbers = record.answer.get(cut, {})
                if numbers or record.failed:
                    cells = [numbers.get(column.name) for column in COLUMNS]
                    who = (FAMILIES[family], setting, WORDS[cut], record.case.patient)
                    rows.append(Row((*who, *cells), note=record.failed or ""))
            if rows:
                table.rows.extend([*rows, mean_row((FAMILIES[family], setting, WORDS[cut], "mean"), rows)])
    return table
