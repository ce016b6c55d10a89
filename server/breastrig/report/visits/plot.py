"""Measures over the visits as one SVG: a panel a measure, left and right with their bands, published ranges in grey."""

from collections.abc import Mapping, Sequence
from datetime import date
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import escape

from breastrig.languages.translation import said
from breastrig.report.measures import ALONG_SKIN, STRAIGHT

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 720, 170, 70, 24, 34, 46  # pixels of a panel and around its axes
LOW_END, END = HEIGHT - FOOT, WIDTH - RIGHT
SIDES = {"left": ("#0b5394", "L", -4.0), "right": ("#b45309", "R", 4.0), "value": ("#333333", "", 0.0)}
INK, GREY, FAINT = "#333333", "#e5e5e5", "#555555"

Rows = Sequence[Mapping[str, Any]]


def visits_svg(stance: Mapping[str, Any], published: Rows, language: str) -> bytes:
    """The panels of one stance of a document breastrig/visits@1: those of its `plotted` measures that have numbers."""
    context = {each["measure"]: each for each in published}
    panels = []
    for name, kind in stance["plotted"]:
        rows = [row for row in stance["measures"] if (row["measure"], row["kind"]) == (name, kind)]
        if any(row[side] is not None for row in rows for side in SIDES):
            panels.append(_panel(rows, stance["visits"], context.get(name), language))
    height = len(panels) * HEIGHT
    body = "".join(f'<g transform="translate(0 {n * HEIGHT})">{panel}</g>' for n, panel in enumerate(panels))
    size = f'viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" lang="{language}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">{body}</svg>\n'.encode()


def _panel(rows: Rows, visits: Rows, context: Mapping[str, Any] | None, language: str) -> str:
    times, unit = (100.0, "%") if rows[0]["unit"] == "1" else (1.0, rows[0]["unit"])
    numbers = [row[f"{side}{end}"] for row in rows for side in SIDES for end in ("", "_low", "_high")]
    ends = [times * number for number in numbers if number is not None]
    ends += [] if context is None else [context["low"], context["high"]]
    room = 0.08 * max(max(ends) - min(ends), 1.0)
    low, high = min(ends) - room, max(ends) + room
    days = [date.fromisoformat(visit["date"]).toordinal() for visit in visits]

    def x(visit: int) -> float:
        return LEFT + 34.0 + (days[visit] - days[0]) / max(days[-1] - days[0], 1) * (END - LEFT - 68.0)

    def y(value: float) -> float:
        return float(TOP + (high - value) / (high - low) * (LOW_END - TOP))

    words = rows[0]["label"], *({rows[0]["kind"]} & {STRAIGHT, ALONG_SKIN})
    parts = [_text(LEFT, 16, f"{', '.join(said(word, language) for word in words)} ({unit})", "start", 12, INK)]
    if context is not None:
        top = y(context["high"])
        band = f'y="{top:.1f}" width="{END - LEFT}" height="{y(context["low"]) - top:.1f}" fill="{GREY}"'
        parts.append(f'<rect x="{LEFT}" {band}/>')
        parts.append(_line((LEFT, y(context["median"])), (END, y(context["median"])), FAINT, "4 3"))
        parts.append(_text(END, 29, said(context["said"], language), "end", 10, FAINT))
    for value in (low + room, high - room):
        parts += [
            _text(LEFT - 8, y(value) + 4, f"{value:.0f}", "end", 11, INK),
            _line((LEFT - 4, y(value)), (LEFT, y(value))),
        ]
    parts += [_line((LEFT, TOP), (LEFT, LOW_END)), _line((LEFT, LOW_END), (END, LOW_END))]
    for place, visit in enumerate(visits):
        parts.append(_text(x(place), LOW_END + 14, said(visit["date"], language), "middle", 10, INK))
        parts.append(_text(x(place), LOW_END + 27, visit["label"], "middle", 10, INK))
    for side, (colour, letter, shift) in SIDES.items():
        shown = [(x(row["visit"]) + shift, row) for row in rows if row[side] is not None]
        points = [(at, y(times * row[side])) for at, row in shown]
        parts += [_line(a, b, colour) for a, b in pairwise(points)]
        for (at, row), (_, here) in zip(shown, points, strict=True):
            if row[f"{side}_low"] is not None:
                parts.append(_line((at, y(times * row[f"{side}_low"])), (at, y(times * row[f"{side}_high"])), colour))
            fill = "#ffffff" if side == "right" else colour
            parts.append(f'<circle cx="{at:.1f}" cy="{here:.1f}" r="3.5" fill="{fill}" stroke="{colour}"/>')
        if points and letter:
            parts.append(_text(points[-1][0] + 10, points[-1][1] + 4, letter, "start", 11, colour))
    return "".join(parts)


def _line(start: tuple[float, float], end: tuple[float, float], colour: str = INK, dashes: str = "none") -> str:
    places = f'x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}"'
    return f'<line {places} stroke="{colour}" stroke-dasharray="{dashes}"/>'


def _text(x: float, y: float, words: str, anchor: str, size: int, colour: str) -> str:
    style = f'text-anchor="{anchor}" font-size="{size}" fill="{colour}"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {style}>{escape(words)}</text>'
