"""Page one: large, the scan with its drawing; small, the fitted model coloured by its distance to the scan."""

from collections.abc import Sequence

from breastrig.rendering.picture import NOISE_MM
from breastrig.report.document import Reported
from breastrig.report.pages.page import MARGIN, QUIET, WARNING, WIDTH, Cell, Sheet
from breastrig.report.pages.page_ptosis import draw_ptosis
from breastrig.report.pages.sentences import warning_of
from breastrig.report.pictures import LIMIT_MM, colour_bar, distance_pictures, jpeg, scan_pictures, views_of
from breastrig.report.table import Row, Value, number

GAP = 4.0  # mm between pictures
LARGE = (0.5 * (WIDTH - GAP), 92.0)  # mm
SMALL = (0.25 * (WIDTH - 3 * GAP), 48.0)  # mm
PIXELS_PER_MM = 7.0  # 180 to the inch: sharp on paper, and half a megabyte
NOT_MEASURED = ("-", "-", "-")  # the width of a lying breast's base
GLANCE = (  # of breasts; of a rig without them its first
    ("notch_nipple", "along the skin"),
    ("nipple_fold", "along the skin"),
    ("nipple_midline", "straight"),
    ("base_width", "straight"),
    ("volume", "volume"),
)


def pictures_page(sheet: Sheet, stances: Sequence[Reported], top: float) -> None:
    """Draws the page."""
    one = len(stances) == 1
    large = [(stances[0], ("front", "three_quarter"))] if one else [(each, ("front",)) for each in stances]
    small = ("front", "three_quarter_right", "three_quarter", "left") if one else ("front", "three_quarter")
    height = max(view.height for each, names in large for view in views_of(each.stance, names, LARGE[0] / LARGE[1]))
    below = top + 5.0 + LARGE[1] + 5.0
    for index, (each, names) in enumerate(large):
        x = MARGIN + index * (LARGE[0] + GAP)
        title = (
            each.name.capitalize() + ": scan with the drawing"
            if each.stance.lines
            else each.name.capitalize() + ": scan"
        )
        sheet.words(x, top, title, 9.0, bold=True)
        cameras = views_of(each.stance, names, LARGE[0] / LARGE[1], height)
        for k, picture in enumerate(scan_pictures(each.stance, cameras, _pixels(LARGE))):
            at = x + k * (LARGE[0] + GAP)
            sheet.picture(jpeg(picture), at, top + 5.0, *LARGE, f"{each.name}: the scan, {_spoken(names[k])}")
        said = _distance_words(each)
        sheet.words(x, below, "Fitted model, distance to the scan", 9.0, bold=True)
        sheet.words(x, below + 4.4, said, 7.5, QUIET, "L", LARGE[0] if not one else WIDTH)
        if warning := warning_of(each):
            sheet.words(x, top, warning, 9.0, WARNING, "R", LARGE[0] if not one else WIDTH, bold=True)
        cameras = views_of(each.stance, small, SMALL[0] / SMALL[1])
        for k, picture in enumerate(distance_pictures(each.stance, cameras, _pixels(SMALL))):
            at = x + k * (SMALL[0] + GAP)
            sheet.picture(jpeg(picture), at, below + 9.0, *SMALL, f"{each.name}: the fit, {_spoken(small[k])}")
    y = _colour_bar(sheet, below + 9.0 + SMALL[1] + 3.0)
    _at_a_glance(sheet, stances, y + 4.0)


def _pixels(size: tuple[float, float]) -> tuple[int, int]:
    return round(PIXELS_PER_MM * size[0]), round(PIXELS_PER_MM * size[1])


def _spoken(view: str) -> str:
    return view.replace("_", " ")


def _distance_words(each: Reported) -> str:
    found = each.result["surface_distance_mm"]
    if found["mean"] is None:
        return "the scan shows no skin near the model"
    share = f"; scan seen by {100 * found['coverage']:.0f} % of the model" if "coverage" in found else ""
    return f"mean {found['mean']:.1f} mm, 95 % within {found['p95']:.1f} mm{share}"


def _colour_bar(sheet: Sheet, y: float) -> float:
    """The meaning of the colours; the y below it."""
    width = 84.0
    x = MARGIN + 0.5 * (WIDTH - width)
    sheet.picture(jpeg(colour_bar(round(width * PIXELS_PER_MM), 28)), x, y, width, 3.2, "colours of the distance")
    sheet.words(MARGIN, y + 0.3, "model inside the scan", 7.5, QUIET, "R", x - MARGIN - 3.0)
    sheet.words(x + width + 3.0, y + 0.3, "model outside", 7.5, QUIET)
    for place in (-LIMIT_MM, -NOISE_MM, 0.0, NOISE_MM, LIMIT_MM):
        middle = x + 0.5 * (1.0 + place / LIMIT_MM) * width
        text = f"{place:+g} mm" if place else "0"
        sheet.words(middle - 10.0, y + 4.0, text, 7.0, QUIET, "C", 20.0)
    said = (
        "pale: within the scanner's error.   grey: the scan shows no skin there.   "
        "dotted line: carried by the model over a hole of the scan."
    )
    sheet.words(MARGIN, y + 8.6, said, 7.0, QUIET, "C", WIDTH)
    return y + 12.0


def _at_a_glance(sheet: Sheet, stances: Sequence[Reported], y: float) -> None:
    """The numbers that are asked for first."""
    known = [{(row.measure, row.kind): row for row in each.rows} for each in stances]
    shown = [key for key in GLANCE if any(key in rows for rows in known)] or list(known[0])[: len(GLANCE)]
    if not shown:
        return
    y = sheet.heading(MARGIN, y, "At a glance")
    column = (WIDTH - 62.0) / (3 * len(stances))
    headings: list[Cell] = [(MARGIN, 62.0, "", "L")]
    for index, each in enumerate(stances):
        for k, side in enumerate(("left", "right", "L - R")):
            name = f"{each.name}, {side}" if k < 2 else side
            headings.append((MARGIN + 62.0 + (3 * index + k) * column, column - 2.0, name, "R"))
    y = sheet.row(y, headings, size=7.0, shade=QUIET, height=5.0)
    for place, key in enumerate(shown):
        first = next(rows[key] for rows in known if key in rows)
        label = first.label if key[0] == "volume" else f"{first.label}, {first.kind}"
        cells: list[Cell] = [(MARGIN + 1.0, 61.0, f"{label} ({first.unit})", "L")]
        for index, rows in enumerate(known):
            for k, text in enumerate(_three(rows[key]) if key in rows else NOT_MEASURED):
                cells.append((MARGIN + 62.0 + (3 * index + k) * column, column - 2.0, text, "R"))
        band = (MARGIN, WIDTH) if place % 2 else None
        y = sheet.row(y, cells, band=band, height=5.4, size=8.5)
    sheet.words(MARGIN, y + 1.5, "left and right are the patient's", 7.0, QUIET)
    draw_ptosis(sheet, stances, y + 7.0)


def _three(row: Row) -> tuple[str, str, str]:
    if row.value is not None:
        return number(row.value, row.unit), "", ""
    difference = None if row.difference is None else Value(row.difference)
    return number(row.left, row.unit), number(row.right, row.unit), number(difference, row.unit, signed=True)
