"""Sentences on paper, none of them cut short: below the numbers where there is room, else on pages of their own."""

from collections.abc import Sequence
from dataclasses import dataclass

from breastrig.report.pages.page import FOOT, HEADING, MARGIN, TOP, WIDTH, Sheet, line_height
from breastrig.report.pages.sentences import HOW, Section

GAP = 3.6  # mm between two paragraphs
LAST = FOOT - 2.0  # mm, where words end


@dataclass(frozen=True)
class Paragraph:
    """Lines of a section that stand together."""

    section: Section
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Layout:
    """Where the paragraphs stand."""

    below: tuple[Paragraph, ...]  # the numbers
    pages: tuple[tuple[Paragraph, ...], ...]


def laid_out(sheet: Sheet, sections: Sequence[Section], y: float) -> Layout:
    """The first sections stand below y while they fit there whole, the others on pages of their own, in order."""
    below: list[Paragraph] = []
    pages: list[list[Paragraph]] = []
    for section in sections:
        lines = sheet.broken(WIDTH, section.text, section.size)
        step = line_height(section.size)
        if not pages:
            if y + HEADING + len(lines) * step <= LAST:
                below.append(Paragraph(section, tuple(lines)))
                y += HEADING + len(lines) * step + GAP
                continue
            pages, y = [[]], TOP
        while lines:
            room = int((LAST - y - HEADING) / step)
            if room < min(len(lines), 2):  # no heading above a single line
                pages.append([])
                y = TOP
                continue
            pages[-1].append(Paragraph(section, tuple(lines[:room])))
            y += HEADING + len(lines[:room]) * step + GAP
            lines = lines[room:]
    return Layout(tuple(below), tuple(tuple(page) for page in pages))


def fits_below(words: Layout, y: float) -> bool:
    """Whether all that stands on pages of its own is how it was measured, and has room on another page below y."""
    paragraphs = [paragraph for page in words.pages for paragraph in page]
    if any(one.section.heading != HOW for one in paragraphs):
        return False  # doubts and the plan are looked for where the numbers end
    return y + sum(HEADING + len(one.lines) * line_height(one.section.size) + GAP for one in paragraphs) <= LAST


def draw_words(sheet: Sheet, paragraphs: Sequence[Paragraph], y: float) -> None:
    """Draws the paragraphs from y downwards."""
    for one in paragraphs:
        y = sheet.heading(MARGIN, y, one.section.heading)
        y = sheet.text_lines(MARGIN, y, one.lines, one.section.size) + GAP
