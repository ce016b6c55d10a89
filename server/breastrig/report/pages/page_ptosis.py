"""The grade of ptosis of each standing stance, with the heights that it was read off."""

from collections.abc import Sequence

from breastrig.report.document import Reported
from breastrig.report.pages.page import MARGIN, QUIET, WIDTH, Cell, Sheet
from breastrig.report.table import Row, with_band, with_margin

NAME = 62.0  # mm of a row's name, as in the table above it
MEASURES = ("nipple_above_fold", "lowest_point_above_fold")
SCALE = (
    "I: nipple at the fold or up to 10 mm below; II: up to 30 mm; III: more, or at the lowest contour; "
    "glandular: only the lowest point hangs, 20 mm and more below the fold"
)


def draw_ptosis(sheet: Sheet, stances: Sequence[Reported], y: float) -> float:
    """Draws the block, if a stance has a grade; the y below it."""
    found = [(one.name, {row.measure: row for row in one.rows}) for one in stances]
    graded = [(name, rows) for name, rows in found if "ptosis" in rows]
    if not graded:
        return y
    y = sheet.heading(MARGIN, y, "Ptosis (Regnault)")
    column = 0.5 * (WIDTH - NAME)
    for name, rows in graded:
        cells: list[Cell] = [(MARGIN + 1.0, NAME, name, "L")]
        for place, side in enumerate(("left", "right")):
            cells.append((MARGIN + NAME + place * column, column - 1.0, _words(rows, side), "L"))
        y = sheet.row(y, cells, height=5.0, size=8.0)
    said = f"Heights above the fold in mm, below it less than zero. {SCALE}."
    return sheet.lines(MARGIN, y + 1.0, WIDTH, said, 7.0, QUIET, most=2)


def _words(rows: dict[str, Row], side: str) -> str:
    """left I (none to I): nipple -3.0 ±5, lowest point -22.1 ±6."""
    grade, nipple, low = (getattr(rows[name], side) for name in ("ptosis", *MEASURES))
    return (
        f"{side} {with_band(grade, 'grade')}: nipple {with_margin(nipple, 'mm')}, lowest point {with_margin(low, 'mm')}"
    )
