"""The pages: what was seen, what was measured, what to know about it, and where the drawing lies by the tape."""

from collections.abc import Sequence

from breastrig.report.document import Reported
from breastrig.report.pages.page import FOOT, TOP, Sheet
from breastrig.report.pages.page_of_numbers import numbers_page
from breastrig.report.pages.page_of_pictures import pictures_page
from breastrig.report.pages.page_of_tape import draw_tape, tape_pages
from breastrig.report.pages.page_of_words import GAP, Layout, draw_words, fits_below, laid_out
from breastrig.report.pages.sentences import sections, warning_of
from breastrig.report.tape import TapePoint, tape_points

TITLE = "Measures from a 3D scan"


def report_pdf(stances: Sequence[Reported]) -> bytes:
    """The report of one or two stances; the same bytes for the same fits."""
    names = " and ".join(one.name for one in stances)
    points = [tape_points(one.stance) for one in stances]
    draft = Sheet("", 1)
    words = _words(draft, stances)
    below_tape = _draw_tape(draft, stances, points) + GAP
    own = () if fits_below(words, below_tape) else words.pages
    warning = " · ".join(f"{warning_of(one)} ({one.name})" for one in stances if warning_of(one))
    sheet = Sheet("BreastRig report", 2 + len(own) + sum(tape_pages(len(each)) for each in points), warning)
    sheet.titled(TITLE, names, "Scan, drawing and fit")
    pictures_page(sheet, stances, TOP)
    sheet.titled(TITLE, names, "Measures and settings")
    draw_words(sheet, words.below, numbers_page(sheet, stances, TOP))
    for page in own:
        sheet.titled(TITLE, names, "Doubts, notes and methods")
        draw_words(sheet, page, TOP)
    _draw_tape(sheet, stances, points)
    for page in () if own else words.pages:
        draw_words(sheet, page, below_tape)
    return sheet.finished()


def _draw_tape(sheet: Sheet, stances: Sequence[Reported], points: Sequence[Sequence[TapePoint]]) -> float:
    """The y below the last page; FOOT where the last stance has none."""
    y = FOOT
    for one, each in zip(stances, points, strict=True):
        y = draw_tape(sheet, one, each)
    return y


def _words(draft: Sheet, stances: Sequence[Reported]) -> Layout:
    """The first page's footer says how many there are: so the numbers are drawn once before, to see what is left."""
    draft.add_page()
    return laid_out(draft, sections(stances), numbers_page(draft, stances, TOP))
