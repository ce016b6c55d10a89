"""The report's measures on the page: how far they are off, and whether their bands hold."""

from breastrig_studies.page.section import Section
from breastrig_studies.tables.measures import PICKS
from breastrig_studies.tables.table import Table


def measures_section(table: Table, ptosis: Table | None = None) -> Section:
    """Of lengths and volumes; the table has the ratios too."""
    place = {column.name: index for index, column in enumerate(table.columns)}
    parts = []
    for unit, words in (("mm", "lengths"), ("ml", "volumes")):
        rows = [row.cells for row in table.rows if row.cells[place["unit"]] == unit]
        for kind, picks in PICKS.items():
            errors, shares = (
                [value for row in rows if isinstance(value := row[place[f"{kind}_{name}"]], float)]
                for name in ("error", "held")
            )
            if errors and shares:
                mean, held = sum(errors) / len(errors), sum(shares) / len(shares)
                parts.append(f"{words}, {picks}: {mean:.1f} {unit} off on average, {held:.0f} % within the band")
    return Section(
        "measures",
        "Are the report's measures right?",
        "Each measure is compared with the same measure on the whole true surface, between the true landmarks.",
        ("; ".join(parts).capitalize() + ".",) if parts else (),
        (),
        ("measures",) if ptosis is None else ("measures", "ptosis"),
    )
