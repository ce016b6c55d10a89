"""The sections of the page about carried drawings."""

from collections.abc import Sequence

from breastrig_studies.page.section import Section, capital, mm
from breastrig_studies.studies.lesions import WAYS as LESION_WAYS
from breastrig_studies.studies.transfer import PICKS, WAYS
from breastrig_studies.tables.accuracy import FAMILIES
from breastrig_studies.tables.table import Row, Table, mean

WORDS = dict(zip(PICKS, ("true picks", "picks 5\u00a0mm off", "one nipple picked 30\u00a0mm off"), strict=True))


def transfer(table: Table) -> Section:
    names = [column.name for column in table.columns]
    answers = []
    for family, word in FAMILIES.items():
        for picks in PICKS:
            rows = [row for row in table.rows if row.cells[0] == word and row.cells[names.index("picks")] == picks]
            rows = [row for row in rows if not row.mean and not row.note]
            if rows:
                answers.append(_sentence(family, picks, rows, names))
    return Section(
        "transfer",
        "How far from its true place is a drawing that was carried to another stance?",
        "The lumpectomy drawing, the breasts' meridians and short strokes in all directions, put on one scan and "
        "carried to the other stance of the same patient, where their true place is known to the triangle; only where "
        "both scans saw the skin. A user could have instead: a rigid motion, or a thin-plate spline, through the "
        "landmarks snapped to the scan.",
        tuple(answers),
        (),
        tuple(name for name in (table.name, "transfer_lines")),
    )


def _sentence(family: str, picks: str, rows: Sequence[Row], names: Sequence[str]) -> str:
    def column(name: str) -> list[float | None]:
        cells = [row.cells[names.index(name)] for row in rows]
        return [float(cell) if isinstance(cell, int | float) else None for cell in cells]

    parts = [
        f"{way} {mm(mean(column(f'{way}_mm')), 1)} (95\u00a0% {mm(mean(column(f'{way}_p95_mm')), 1)})" for way in WAYS
    ]
    pairs = zip(column("skin_mm"), column("spline_mm"), strict=True)
    worse = sum(ours is not None and spline is not None and ours > spline for ours, spline in pairs)
    return (
        f"{capital(family)}, {WORDS[picks]}, {len(rows)} transfers: {', '.join(parts)}; "
        f"the program's way was worse than the spline in {worse} of them."
    )


def lesions(table: Table) -> Section:
    names = [column.name for column in table.columns]
    answers = []
    for row in table.rows:
        cells = dict(zip(names, row.cells, strict=True))
        if row.mean:
            ways = [
                f"{way} {mm(_number(cells[f'{way}_mm']), 1)} (95\u00a0% {mm(_number(cells[f'{way}_p95_mm']), 1)})"
                for way in LESION_WAYS
            ]
            answers.append(f"{capital(str(row.cells[0]))}, {cells['from']} to {cells['to']}: {', '.join(ways)}.")
    return Section(
        "lesions",
        "How far from its true place is a lesion that was carried to another stance?",
        "Balls inside the breasts, whose tissue was followed by finite elements; both scans are fitted with their "
        "landmarks. Decision 0015 says how they are carried.",
        tuple(answers),
        (),
        (table.name,),
    )


def prediction(table: Table) -> Section:
    names = [column.name for column in table.columns]
    means = [dict(zip(names, row.cells, strict=True)) for row in table.rows if row.mean]
    answers = [
        f"{capital(str(cells[names[0]]))}, {cells['to']}, {cells['places']}: "
        f"{mm(_number(cells['predicted_mm']), 1)}, moved rigidly {mm(_number(cells['rigid_mm']), 1)}."
        for cells in means
    ]
    return Section(
        "prediction",
        "How far off is a stance that was not scanned?",
        "Predicted from the standing scan with its landmarks alone. Decision 0020 says how.",
        tuple(answers),
        (),
        (table.name,),
    )


def _number(cell: object) -> float | None:
    return float(cell) if isinstance(cell, int | float) else None


def other_patient(table: Table) -> Section:
    names = [column.name for column in table.columns]
    answers = []
    for family, word in FAMILIES.items():
        rows = [row for row in table.rows if row.cells[0] == word]
        if rows:
            cells = [row.cells[names.index("difference")] for row in rows]
            difference = mean(float(cell) for cell in cells if isinstance(cell, int | float)) or 0.0
            answers.append(
                f"{capital(family)}: a shape's distance to nipple and fold differs between the two patients by "
                f"{100 * difference:.0f}\u00a0% of the distance from nipple to xiphoid."
            )
    return Section(
        "other-patient",
        "Is a drawing that was carried to another patient at the same place of her breast?",
        "Two patients share no skin; the place is judged by each shape's distance to the true nipple and fold, "
        "relative to the size of the breast.",
        tuple(answers),
        (),
        (table.name,),
    )
