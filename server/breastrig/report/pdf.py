"""The pages: what was seen, what was measured, and where the drawing lies by the tape."""

from collections.abc import Sequence

from breastrig.report.document import Reported
from breastrig.report.pages.page import MARGIN, QUIET, WIDTH, Sheet
from breastrig.report.pages.page_of_numbers import numbers_page
from breastrig.report.pages.page_of_pictures import pictures_page
from breastrig.report.pages.page_of_tape import draw_tape, tape_pages
from breastrig.report.tape import tape_points


def report_pdf(stances: Sequence[Reported]) -> bytes:
    """The report of one or two stances; the same bytes for the same fits."""
    points = [tape_points(one.stance) for one in stances]
    sheet = Sheet("BreastRig report", 2 + sum(tape_pages(len(each)) for each in points))
    for page, subtitle in ((pictures_page, "Scan, drawing and fit"), (numbers_page, "Measures and settings")):
        sheet.add_page()
        sheet.words(MARGIN, 13.0, "Breast measures from a 3D scan", 15.0, bold=True)
        sheet.words(MARGIN, 14.6, " and ".join(one.name for one in stances), 10.0, QUIET, "R", WIDTH)
        sheet.words(MARGIN, 20.4, subtitle, 9.0, QUIET)
        sheet.rule(26.0)
        page(sheet, stances, 30.0)
    for one, each in zip(stances, points, strict=True):
        draw_tape(sheet, one, each)
    return sheet.finished()
