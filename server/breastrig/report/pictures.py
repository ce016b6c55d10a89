"""The report's pictures: the scan with its drawing, and the model coloured by its 90 % radii."""

import io
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from PIL import Image

from breastrig.core.arrays import Array
from breastrig.core.srgb import rgb, to_light, to_srgb
from breastrig.drawings.inks import LESION
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.polyline import Polyline, resampled
from breastrig.geometry.rays import RayCaster
from breastrig.rendering.picture import Camera, Colour, Layer, Line, Picture, Scene, camera
from breastrig.report.body_frame import body_frame
from breastrig.report.line_bands import LineBands
from breastrig.report.stance import Stance
from breastrig.scan.clean import Surface

LEAST_SURE_MM = 20.0  # end of the colours; the same in every report, so that reports compare
SURE: Colour = (0.97, 0.95, 0.90)
UNSURE: Colour = (0.45, 0.20, 0.50)
UNKNOWN: Colour = (0.60, 0.60, 0.60)
SCAN_GREY: Colour = (0.80, 0.78, 0.76)
PREDICTED: Colour = (0.70, 0.78, 0.90)  # of a body that no scan shows: as the page tints it, bluish
PALE: Colour = (0.93, 0.93, 0.93)  # parts beside the trunk: table, forearms
BODY_REACH = (0.015, 0.04)  # m from the model, where grey begins to turn pale and has done so
# as on the page; of lines without a hue too: white and grey ones do not show on a grey scan
INK: Colour = (0.063, 0.063, 0.063)
DASH, GAP = 0.006, 0.005  # m, where the scan shows no skin: as on the page
HUE = 0.15  # least difference between a colour's channels that people see as one
LIGHTEST = 0.15  # luminance of a line: 3 : 1 against the scan, as WCAG 2.2 (1.4.11) asks of graphics
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear red, green, blue (WCAG 2.2)
WHITE: Colour = (1.0, 1.0, 1.0)
JPEG_QUALITY = 92  # below it lines get a halo


def views_of(stance: Stance, names: Sequence[str], aspect: float, height: float | None = None) -> list[Camera]:
    """Cameras on the model's body, one scale for all; `height` (m) fixes it."""
    frame = body_frame(stance.rig, stance.vertices).axes
    cameras = [camera(name, stance.vertices, frame, aspect, margin=0.02) for name in names]
    shown = max(view.height for view in cameras) if height is None else height
    return [Camera(view.centre, view.axes, shown) for view in cameras]


def scan_pictures(stance: Stance, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    """The scan in grey with the drawing on it; parts that the scan did not see, but the model carries, are dashed."""
    if stance.predicted:
        return _predicted_pictures(stance, cameras, size)
    apart = stance.search.query(stance.scan_vertices).distances
    share = np.clip((apart - BODY_REACH[0]) / (BODY_REACH[1] - BODY_REACH[0]), 0.0, 1.0)[:, None]
    colours = (1.0 - share) * np.asarray(SCAN_GREY) + share * np.asarray(PALE)
    return _rendered(stance, Layer(stance.scan_vertices, stance.scan_faces, colours), cameras, size)


def _predicted_pictures(stance: Stance, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    """The smooth model in a tint of its own with the drawing laid on it, dashed: nobody has scanned this body."""
    on_model = [replace(line, points=stance.search.query(line.points).points) for line in stance.lines]
    laid = replace(stance, lines=tuple(replace(line, bridged=np.ones(len(line), bool)) for line in on_model))
    return _rendered(laid, Layer(stance.vertices, stance.rig.faces, PREDICTED), cameras, size)


def _rendered(stance: Stance, skin: Layer, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    scene, lines, bands = Scene([skin]), _lines(stance, size[1]), _bands(stance, skin)
    return [scene.render(view, size, lines, paint=bands.paint) for view in cameras]


def _bands(stance: Stance, skin: Layer) -> LineBands:
    normals = vertex_normals(skin.vertices, skin.faces)
    return LineBands([(line, _colours(line.color)[0]) for line in stance.banded], skin.vertices, normals)


def uncertainty_pictures(stance: Stance, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    """The model, darker where its location is less certain; grey where that is not known."""
    assert stance.radii is not None
    scene = Scene([Layer(stance.vertices, stance.rig.faces, uncertainty_colours(1e3 * stance.radii))])
    return [scene.render(view, size) for view in cameras]


def colour_bar(width: int, height: int) -> Picture:
    """(height, width, 3): from 0 at the left to LEAST_SURE_MM at the right."""
    colours = uncertainty_colours(np.linspace(0.0, LEAST_SURE_MM, width))
    return np.rint(255.0 * np.broadcast_to(colours, (height, width, 3))).astype(np.uint8)


def uncertainty_colours(radii_mm: Array) -> Array:
    """(M, 3), pale at 0 to dark at LEAST_SURE_MM."""
    share = np.clip(np.nan_to_num(radii_mm) / LEAST_SURE_MM, 0.0, 1.0)[..., None]
    colours = (1.0 - share) * np.asarray(SURE) + share * np.asarray(UNSURE)
    return np.where(np.isnan(radii_mm)[..., None], UNKNOWN, colours)


def jpeg(picture: Picture) -> bytes:
    """The picture as JPEG, deterministic."""
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    return stream.getvalue()


def line_colour(color: str) -> Colour:
    """A line's own "#rrggbb", so dark that it shows on the grey scan, on paper too; INK where it has no hue."""
    own = np.array(rgb(color)) / 255.0
    if np.ptp(own) < HUE:
        return INK
    linear = to_light(own)
    linear *= min(1.0, LIGHTEST / float(LUMINANCE @ linear))
    red, green, blue = to_srgb(linear)
    return float(red), float(green), float(blue)


def _lines(stance: Stance, pixels: int) -> list[Line]:
    """Each line with an outline below it, which shows on light and on dark skin."""
    thick = pixels / 150
    strokes = [(*stroke, *_colours(line.color)) for line in stance.lines for stroke in _strokes(line)]
    halos = [Line(points, outline, 2.0 * thick, closed) for points, closed, _, outline in strokes]
    return halos + [Line(points, colour, thick, closed) for points, closed, colour, _ in strokes]


def _colours(color: str) -> tuple[Colour, Colour]:
    """Of a line and its outline: white around dark lines, dark around the yellow of lesions."""
    if color.lower() == LESION:
        red, green, blue = (channel / 255.0 for channel in rgb(color))
        return (red, green, blue), INK
    return line_colour(color), WHITE


def _strokes(line: Polyline) -> list[tuple[Array, bool]]:
    """Runs of points on the scan, and dashes where they are bridged."""
    if not line.bridged.any():
        return [(line.points, line.closed)]
    strokes: list[tuple[Array, bool]] = []
    for run, bridged in line.runs():
        strokes += [(dash, False) for dash in _dashes(run)] if bridged else [(run, False)]
    return strokes


def _dashes(run: Array) -> list[Array]:
    """(M, 3) m each."""
    fine = resampled(run, 0.001, False)
    phase = 0.001 * np.arange(len(fine)) % (DASH + GAP)
    inked = np.split(fine, np.flatnonzero(np.diff(phase < DASH)) + 1)
    return inked[::2]


Image.preinit()  # Pillow's formats: here once in the fork server, else at the first picture in each upload's process
SIZE = (144, 180)  # pixels: sharp at 72 x 90 on a fine screen


def thumbnail_png(surface: Surface, body_frame: dict[str, Any], rays: RayCaster | None = None) -> bytes:
    """PNG of a cleaned scan; `body_frame` has its up and front (unit, the scan's axes).

    `rays` against it are half of the work, where there are some already.
    """
    up, front = (np.asarray(body_frame[name], dtype=np.float64) for name in ("up", "front"))
    frame = np.stack([np.cross(up, front), up, front], axis=1)
    view = camera("front", surface.vertices, frame, SIZE[0] / SIZE[1])
    picture = Scene([Layer(surface.vertices, surface.faces)], rays).render(view, SIZE, background=None)
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "PNG")  # to look for the shortest takes 25 ms, and finds 4 % of 22 kB
    return stream.getvalue()
