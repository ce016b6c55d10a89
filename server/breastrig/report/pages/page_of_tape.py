"""Further pages: the tape sheet of each stance."""

from collections.abc import Sequence

from breastrig.report.document import Reported
from breastrig.report.pages.page import FOOT, MARGIN, QUIET, TOP, WIDTH, Cell, Sheet
from breastrig.report.tape import THREE, TapePoint

ROW = 4.7  # mm
LINE, POINT, ERROR = 42.0, 20.0, 14.0  # mm of these columns
HOW = (
    "Lay the tape on the skin, from each landmark in the direction of the point, and mark the arc; where the three "
    "arcs meet is the point. Lengths are those of the shortest way on the fitted skin in this stance. ± holds the true "
    "place nine times of ten; none is given for what was drawn on this very scan."
)


def tape_pages(rows: int) -> int:
    """How many pages so many key points take."""
    return -(-rows // _room()) if rows else 0


def _room() -> int:
    return int((FOOT - TOP - 34.0) / ROW)


def draw_tape(sheet: Sheet, each: Reported, points: Sequence[TapePoint]) -> float:
    """Draws one stance's pages, which the caller has counted; the y below the last one's words, FOOT without a page."""
    y = FOOT
    for first in range(0, len(points), _room()):
        sheet.titled("Tape sheet", each.name, "Key points of the drawing, along the skin from three landmarks (mm)")
        y = _table(sheet, points[first : first + _room()], TOP)
        y = sheet.lines(MARGIN, y + 3.0, WIDTH, HOW, 7.5)
    return y


def _table(sheet: Sheet, points: Sequence[TapePoint], y: float) -> float:
    each = (WIDTH - LINE - POINT - ERROR) / THREE
    head: list[Cell] = [(MARGIN, LINE, "line", "L"), (MARGIN + LINE, POINT, "point", "L")]
    head += [(MARGIN + LINE + POINT + k * each, each, f"from landmark {k + 1}", "L") for k in range(THREE)]
    head.append((MARGIN + WIDTH - ERROR, ERROR, "±", "R"))
    y = sheet.row(y, head, size=7.0, shade=QUIET, height=4.4)
    before = ""
    for place, point in enumerate(points):
        cells: list[Cell] = [(MARGIN + 1.0, LINE - 2.0, _spoken(point.line) if point.line != before else "", "L")]
        cells.append((MARGIN + LINE, POINT - 1.0, point.point, "L"))
        for k, (landmark, mm) in enumerate(point.lengths_mm):
            x = MARGIN + LINE + POINT + k * each
            cells.append((x, each - 16.0, _spoken(landmark), "L"))
            cells.append((x + each - 16.0, 12.0, f"{mm:.0f}", "R"))
        if point.error_mm is not None:
            cells.append((MARGIN + WIDTH - ERROR, ERROR - 1.0, f"{point.error_mm:.0f}", "R"))
        y = sheet.row(y, cells, band=(MARGIN, WIDTH) if place % 2 else None, height=ROW)
        before = point.line
    return y


def _spoken(name: str) -> str:
    """suprasternal_notch, wise_L: as people say them."""
    sides = {"_L": ", left", "_R": ", right"}
    stem, side = (name[:-2], sides[name[-2:]]) if name[-2:] in sides else (name, "")
    return stem.replace("_", " ") + side
