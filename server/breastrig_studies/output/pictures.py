"""The best, the median and the worst fit of each family, to look at.

Left: the scan in grey with the model's drawing laid on its skin.  Middle and right: the model coloured by its signed
distance to the scan (blue: the model lies under the scan's skin, orange: above it), from the front and from the side;
grey where the scan shows nothing.
"""

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array
from breastrig.correspondence.distances import ACCEPTED
from breastrig.correspondence.match import match
from breastrig.drawings.project_drawing import on_scan
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.polyline import Polyline
from breastrig.rendering.picture import Layer, Line, camera, diverging_colours
from breastrig.rendering.picture import Scene as Meshes
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import of, value

DRAWING = "lumpectomy"  # where the rig has it, else its first one
LIMIT_MM = 5.0  # ends of the colours
SIZE = (380, 460)  # pixels a picture
SCAN_GREY = (0.74, 0.75, 0.77)
PAPER = (0.955, 0.96, 0.965)
INK = (40, 44, 52)
BAR_HEIGHT = 56  # pixels
VIEWS = (("front", True), ("front", False), ("three_quarter", False))  # (view, the scan instead of the model)


@dataclass(frozen=True, eq=False)
class FitPicture:
    """One row of three pictures."""

    family: str
    place: str  # best | median | worst
    png: bytes


def chosen(records: Sequence[Record], preset: str, family: str) -> list[tuple[str, Record]]:
    """Best, median and worst fit of a family by the distance to the true surface (to the scan where it is unknown)."""
    good = [r for r in of(records, "accuracy", preset) if r.case.family == family and not r.failed]
    ordered = sorted(good, key=_badness)
    names = {len(ordered) // 2: "median", len(ordered) - 1: "worst", 0: "best"}  # of few fits the ends come first
    return [(names[index], ordered[index]) for index in sorted(names) if ordered]


def _badness(record: Record) -> float:
    truth = value(record.answer, "truth_mm.mean")
    return float(value(record.answer, "surface_mm.mean") or 0.0) if truth is None else truth


def signed_distances_mm(scene: Scene, rig: Rig, vertices: Array) -> Array:
    """(V,) mm, above zero where the model lies outside the scan's skin; nan where the scan shows nothing."""
    found = match(scene.target, vertices, vertex_normals(vertices, rig.faces), ACCEPTED)
    result = np.full(len(vertices), np.nan)
    outside = np.einsum("mi,mi->m", vertices[found.vertices] - found.points, found.normals)
    result[found.vertices] = 1e3 * np.where(outside < 0.0, -found.distances, found.distances)
    return result


def _lines(drawn: Sequence[Polyline]) -> list[Line]:
    lines = [Line(line.points, (1.0, 1.0, 1.0), 5.0, line.closed) for line in drawn]
    return lines + [Line(line.points, (0.07, 0.08, 0.1), 2.4, line.closed) for line in drawn]


def fit_row(
    scene: Scene,
    rig: Rig,
    vertices: Array,
    views: Sequence[tuple[str, bool]] = VIEWS,
    frame: Array | None = None,
) -> Image.Image:
    """Scan, and model coloured by distance from two sides (or `views`), each with the first drawing.

    `frame`: (3, 3) the body's left, up and front as columns; by default as the model has them.
    """
    axes = umeyama(rig.template, vertices).rotation if frame is None else frame
    named = [drawing for drawing in rig.drawings if drawing.name == DRAWING] or list(rig.drawings)
    drawn = on_scan(rig, vertices, named[0], scene.target) if named else ()
    model = Meshes([Layer(vertices, rig.faces, diverging_colours(signed_distances_mm(scene, rig, vertices), LIMIT_MM))])
    scan = Meshes([Layer(scene.target.vertices, scene.target.faces, SCAN_GREY)])
    row = Image.new("RGB", (SIZE[0] * len(views), SIZE[1]))
    for column, (view, of_scan) in enumerate(views):
        framed = camera(
            view, scene.target.vertices if of_scan else vertices, frame=axes, aspect=SIZE[0] / SIZE[1], margin=0.05
        )
        meshes = scan if of_scan else model
        row.paste(Image.fromarray(meshes.render(framed, SIZE, _lines(drawn), PAPER)), (column * SIZE[0], 0))
    return row


def with_colour_bar(row: Image.Image) -> Image.Image:
    """The row with the colours' meaning below it."""
    width, height = row.size
    picture = Image.new("RGB", (width, height + BAR_HEIGHT), tuple(round(255 * c) for c in PAPER))
    picture.paste(row, (0, 0))
    pen = ImageDraw.Draw(picture)
    left, right, top = SIZE[0] + 60, width - 60, height + 8
    colours = diverging_colours(np.linspace(-LIMIT_MM, LIMIT_MM, right - left), LIMIT_MM)
    strip = np.rint(255 * np.broadcast_to(colours, (14, right - left, 3))).astype(np.uint8)
    picture.paste(Image.fromarray(strip), (left, top))
    inside, outside = f"-{LIMIT_MM:g} mm, model inside the scan", f"model outside, +{LIMIT_MM:g} mm"
    for x, words, anchor in ((left, inside, "la"), ((left + right) / 2, "0", "ma"), (right, outside, "ra")):
        pen.text((x, top + 17), words, fill=INK, font_size=14, anchor=anchor)
    pen.text((SIZE[0] // 2, top + 10), "scan with the drawing", fill=INK, font_size=14, anchor="ma")
    return picture


def fit_pictures(records: Sequence[Record], rig: Rig, preset: str, progress: Callable[[str], None]) -> list[FitPicture]:
    """The pictures of every family."""
    pictures = []
    for family in ("independent", "makehuman"):
        for place, record in chosen(records, preset, family):
            progress(f"picture of {record.case.patient}, {record.case.name}")
            scene = read_scene(record.case)
            fit = scene.fitted(rig, record.unit.recipe, scene.landmarks)
            stream = io.BytesIO()
            picture = with_colour_bar(fit_row(scene, rig, fit.vertices))
            picture.save(stream, "PNG", optimize=True)
            pictures.append(FitPicture(family, place, stream.getvalue()))
    return pictures
