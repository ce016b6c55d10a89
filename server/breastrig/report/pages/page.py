"""A sheet of A4 with the few things that the report is set with: headings, tables, pictures, quiet rules.

The fonts are PDF's own (Helvetica), which every reader has; their letters are those of Latin-1, anything else becomes
"?".  A page holds no time of its making and no name, so the same fit gives the same bytes.
"""

import io
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Literal

from fpdf import FPDF

from breastrig import __version__
from breastrig.core.notice import LIMITS_OF_USE

Shade = tuple[int, int, int]
Align = Literal["L", "C", "R"]
Cell = tuple[float, float, str, Align]  # x, width, text

INK: Shade = (28, 34, 44)
QUIET: Shade = (108, 116, 128)
WARNING: Shade = (150, 40, 20)  # dark red
RULE: Shade = (206, 211, 218)
BAND: Shade = (246, 247, 249)  # behind every second row
MARGIN = 15.0  # mm
WIDTH = 210.0 - 2 * MARGIN  # mm of text
TOP = 30.0  # mm, below a page's title
FOOT = 284.0  # mm, where the footer begins
HEADING = 5.6  # mm of a section's name and rule
NO_DATE = datetime(2000, 1, 1, tzinfo=UTC)  # a PDF may not be without one; the true one would change the bytes
MM_PER_POINT = 25.4 / 72.0


def line_height(size: float) -> float:
    """mm from line to line of a paragraph, of letters of this size in points."""
    return 1.28 * size * MM_PER_POINT


def latin(text: str) -> str:
    """What the PDF's own fonts can show."""
    for strange, plain in (("−", "-"), ("–", "-"), ("—", "-"), ("’", "'"), ("“", '"'), ("”", '"'), ("…", "...")):
        text = text.replace(strange, plain)
    return " ".join(text.encode("latin-1", "replace").decode("latin-1").split())


class Sheet(FPDF):
    """The document; all places in mm from the upper left corner."""

    def __init__(self, title: str, pages: int, warning: str = "") -> None:
        super().__init__(unit="mm", format="A4")
        self._pages = pages
        self._warning = warning
        self.set_auto_page_break(False)
        self.set_margins(MARGIN, MARGIN, MARGIN)
        self.set_title(title)
        self.set_creator(f"BreastRig {__version__}")
        self.set_producer(f"BreastRig {__version__}")
        self.set_lang("en")
        self.set_creation_date(NO_DATE)

    def footer(self) -> None:
        """On every page, for each may be printed alone: what this is not, and whether its numbers can be trusted."""
        self.rule(FOOT)
        self.words(MARGIN, FOOT + 1.6, LIMITS_OF_USE, 6.5, QUIET)
        self.words(
            MARGIN,
            FOOT + 1.6,
            f"BreastRig {__version__} · page {self.page_no()} of {self._pages}",
            6.5,
            QUIET,
            "R",
            WIDTH,
        )
        if self._warning:
            self.words(MARGIN, FOOT + 4.8, self._warning, 8.0, WARNING, "L", WIDTH, bold=True)

    def words(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 8.0,
        shade: Shade = INK,
        align: Align = "L",
        width: float = 0.0,
        bold: bool = False,
    ) -> None:
        """One line with its upper edge at y; aligned within `width`, made smaller where it would not fit into it."""
        text = latin(text)
        self.set_font("Helvetica", "B" if bold else "", size)
        natural = self.get_string_width(text)
        if width and natural > width:
            self.set_font_size(size * width / natural)
            natural = self.get_string_width(text)
        start = {"L": x, "C": x + 0.5 * (width - natural), "R": x + width - natural}[align]
        self.set_text_color(*shade)
        self.text(start, y + 0.74 * size * MM_PER_POINT, text)

    def lines(
        self, x: float, y: float, width: float, text: str, size: float, shade: Shade = QUIET, most: int = 6
    ) -> float:
        """A paragraph of at most `most` lines; the y below it."""
        broken = self.broken(width, text, size)
        shown = broken if len(broken) <= most else [*broken[: most - 1], broken[most - 1] + " ..."]
        return self.text_lines(x, y, shown, size, shade)

    def broken(self, width: float, text: str, size: float) -> list[str]:
        """The lines of a paragraph."""
        self.set_font("Helvetica", "", size)
        lines = self.multi_cell(
            width, line_height(size), latin(text), dry_run=True, output="LINES", align="L", padding=0
        )
        assert isinstance(lines, list)
        return [str(line) for line in lines]

    def text_lines(self, x: float, y: float, lines: Sequence[str], size: float, shade: Shade = QUIET) -> float:
        """Lines below each other; the y below them."""
        for index, line in enumerate(lines):
            self.words(x, y + index * line_height(size), line, size, shade)
        return y + len(lines) * line_height(size)

    def heading(self, x: float, y: float, text: str, width: float = WIDTH) -> float:
        """A section's name over a rule; the y below it."""
        self.words(x, y, text, 9.0, bold=True)
        self.rule(y + 4.6, x, width)
        return y + HEADING

    def titled(self, title: str, names: str, subtitle: str) -> None:
        """A new page under its title, with the stances it is of."""
        self.add_page()
        self.words(MARGIN, 13.0, title, 15.0, bold=True)
        self.words(MARGIN, 14.6, names, 10.0, QUIET, "R", WIDTH)
        self.words(MARGIN, 20.4, subtitle, 9.0, QUIET)
        self.rule(26.0)

    def rule(self, y: float, x: float = MARGIN, width: float = WIDTH) -> None:
        self.set_draw_color(*RULE)
        self.set_line_width(0.2)
        self.line(x, y, x + width, y)

    def row(
        self,
        y: float,
        cells: Sequence[Cell],
        *,
        height: float = 4.6,
        size: float = 8.0,
        shade: Shade = INK,
        band: tuple[float, float] | None = None,
    ) -> float:
        """Cells (x, width, text, align) of one row; `band` (x, width) is tinted.  The y below it."""
        if band is not None:
            self.set_fill_color(*BAND)
            self.rect(band[0], y, band[1], height, style="F")
        for x, width, text, align in cells:
            self.words(x, y + 0.5 * (height - 0.74 * size * MM_PER_POINT), text, size, shade, align, width)
        return y + height

    def picture(self, content: bytes, x: float, y: float, width: float, height: float, says: str) -> None:
        """JPEG bytes in a box, with words for those who do not see it."""
        self.image(io.BytesIO(content), x, y, width, height, alt_text=says)

    def finished(self) -> bytes:
        return bytes(self.output())
