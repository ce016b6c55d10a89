"""Draws two drawings on one scan: the first black, the second white, thin over holes, the distances below.

Both lines can be distinguished in print and by everyone, on a scan that is shown in the tone between them.
"""

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.drawings.superimposition.gaps import ShapeGap
from breastrig.geometry.polyline import Polyline
from breastrig.rendering.picture import Camera, Colour, Layer, Line, Picture, Scene, camera

SKIN = (0.72, 0.58, 0.50)  # black and white differ from it alike
PAPER = (0.96, 0.96, 0.95)
INK, QUIET = (30, 34, 40), (95, 100, 108)
BLACK, WHITE = (0.04, 0.04, 0.05), (1.0, 1.0, 1.0)
VIEWS = ("three_quarter_right", "front", "three_quarter")
PANEL = (560, 640)  # pixels of one view
WIDTH, OVER_A_HOLE = 3.2, 1.2  # pixels of a line on the skin, and where the scan has none
SCALE_BAR = 0.05  # m
ROW = 24  # pixels of a row of text
MARGIN = 20


def superimposed(
    vertices: Array,
    faces: Integers,
    frame: Array,
    drawings: tuple[Sequence[Polyline], Sequence[Polyline]],
    names: tuple[str, str],
    gaps: Sequence[ShapeGap],
) -> Picture:
    """(H, W, 3): three views of the scan ((V, 3) m, (F, 3)) with both drawings, legend, scale and distances.

    `frame` (3, 3) holds the body's left, up and front directions in the scan's axes as columns.
    """
    points = np.concatenate([shape.points for drawing in drawings for shape in drawing])
    framed = np.concatenate([points, points.mean(axis=0) + 0.16 * np.concatenate([frame.T, -frame.T])])
    scene = Scene([Layer(vertices, faces, SKIN)])
    lines = [
        line
        for drawing, colour in zip(drawings, (BLACK, WHITE), strict=True)
        for shape in drawing
        for line in _drawn(shape, colour)
    ]
    below = MARGIN * 2 + ROW * (len(gaps) + 4)
    sheet = Image.new("RGB", (PANEL[0] * len(VIEWS), PANEL[1] + below), tuple(round(255 * c) for c in PAPER))
    pen = ImageDraw.Draw(sheet)
    for column, view in enumerate(VIEWS):
        seen = camera(view, framed, frame=frame, aspect=PANEL[0] / PANEL[1], margin=0.04)
        sheet.paste(Image.fromarray(scene.render(seen, PANEL, lines, PAPER)), (column * PANEL[0], 0))
        _scale(pen, seen, column * PANEL[0] + MARGIN, PANEL[1] - MARGIN)
    _legend(pen, names, gaps, sheet.width)
    return np.asarray(sheet)


def _drawn(shape: Polyline, colour: Colour) -> list[Line]:
    """The whole line thin, and wide on it what lies on the skin."""
    on_skin = [Line(run, colour, WIDTH) for run, bridged in shape.runs() if not bridged]
    return [Line(shape.outline, colour, OVER_A_HOLE), *on_skin]


def _scale(pen: ImageDraw.ImageDraw, seen: Camera, left: int, bottom: int) -> None:
    length = SCALE_BAR / (seen.height / PANEL[1])
    pen.line([(left, bottom), (left + length, bottom)], fill=INK, width=3)
    pen.text((left + length / 2, bottom - 6), f"{1e3 * SCALE_BAR:.0f} mm", fill=INK, font_size=15, anchor="ms")


def _legend(pen: ImageDraw.ImageDraw, names: tuple[str, str], gaps: Sequence[ShapeGap], width: int) -> None:
    y = PANEL[1] + MARGIN
    pen.rectangle([(MARGIN, y - 6), (MARGIN + 44, y + 2 * ROW - 8)], fill=tuple(round(255 * c) for c in SKIN))
    for row, (name, colour) in enumerate(zip(names, (BLACK, WHITE), strict=True)):
        middle = y + row * ROW + 6
        ink = tuple(round(255 * c) for c in colour)
        pen.line([(MARGIN + 6, middle), (MARGIN + 38, middle)], fill=ink, width=4)
        pen.text((MARGIN + 54, middle), name, fill=INK, font_size=15, anchor="lm")
    pen.text((MARGIN + 54, y + 2 * ROW + 6), "thin where the scan has no skin", fill=QUIET, font_size=14, anchor="lm")
    columns = [width // 2 + k for k in (0, 330, 430, 530)]
    texts = [("distance, both ways (mm)", "mean", "95 %", "max")]
    texts += [(gap.name, f"{gap.mean_mm:.2f}", f"{gap.p95_mm:.2f}", f"{gap.max_mm:.2f}") for gap in gaps]
    for row, entries in enumerate(texts):
        for column, (x, entry) in enumerate(zip(columns, entries, strict=True)):
            place, anchor = (x, y + row * ROW + 6), "lm" if column == 0 else "rm"
            pen.text(place, entry, fill=QUIET if row == 0 else INK, font_size=15, anchor=anchor)
    pen.text((MARGIN, y + ROW * (len(gaps) + 3)), LIMITS_OF_USE, fill=QUIET, font_size=14, anchor="lm")
