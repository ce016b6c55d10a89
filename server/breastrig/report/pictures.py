"""The report's pictures: the scan with its drawing, and the model coloured by its signed distance to the scan."""

import io
from collections.abc import Sequence

import numpy as np
from PIL import Image

from breastrig.core.arrays import Array
from breastrig.rendering.picture import Camera, Colour, Layer, Line, Picture, Scene, camera, diverging_colours
from breastrig.report.body_frame import body_frame
from breastrig.report.stance import Stance

LIMIT_MM = 5.0  # ends of the colours; the same in every report, so that reports compare
SCAN_GREY: Colour = (0.80, 0.78, 0.76)
PALE: Colour = (0.93, 0.93, 0.93)  # what is not her trunk: table, forearms
BODY_REACH = (0.015, 0.04)  # m from the model, where grey begins to turn pale and has done so
INK: Colour = (0.10, 0.16, 0.24)
WHITE: Colour = (1.0, 1.0, 1.0)
JPEG_QUALITY = 92  # below it lines get a halo


def views_of(stance: Stance, names: Sequence[str], aspect: float, height: float | None = None) -> list[Camera]:
    """Cameras on the model's body, one scale for all; `height` (m) fixes it."""
    frame = body_frame(stance.rig, stance.vertices).axes
    cameras = [camera(name, stance.vertices, frame, aspect, margin=0.02) for name in names]
    shown = max(view.height for view in cameras) if height is None else height
    return [Camera(view.centre, view.axes, shown) for view in cameras]


def scan_pictures(stance: Stance, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    """The scan in grey with the drawing on it; parts that the scan did not see, but the model carries, are dotted."""
    apart = stance.search.query(stance.scan_vertices).distances
    share = np.clip((apart - BODY_REACH[0]) / (BODY_REACH[1] - BODY_REACH[0]), 0.0, 1.0)[:, None]
    colours = (1.0 - share) * np.asarray(SCAN_GREY) + share * np.asarray(PALE)
    scene = Scene([Layer(stance.scan_vertices, stance.scan_faces, colours)])
    lines = _lines(stance, size[1])
    return [scene.render(view, size, lines) for view in cameras]


def distance_pictures(stance: Stance, cameras: Sequence[Camera], size: tuple[int, int]) -> list[Picture]:
    """The model in the colours of its distance to the scan: blue inside the scan's skin, orange outside."""
    colours = diverging_colours(1e3 * stance.distances, LIMIT_MM)
    scene = Scene([Layer(stance.vertices, stance.rig.faces, colours)])
    return [scene.render(view, size) for view in cameras]


def colour_bar(width: int, height: int) -> Picture:
    """(height, width, 3): from -LIMIT_MM at the left to +LIMIT_MM at the right."""
    colours = diverging_colours(np.linspace(-LIMIT_MM, LIMIT_MM, width), LIMIT_MM)
    return np.rint(255.0 * np.broadcast_to(colours, (height, width, 3))).astype(np.uint8)


def jpeg(picture: Picture) -> bytes:
    """The same bytes for the same picture."""
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    return stream.getvalue()


def _lines(stance: Stance, pixels: int) -> list[Line]:
    """Each line white below and dark above, which shows on light and on dark skin."""
    thick = pixels / 150
    found: list[Line] = []
    for points, closed in _strokes(stance):
        found.append(Line(points, WHITE, 2.0 * thick, closed))
    return found + [Line(points, INK, thick, closed) for points, closed in _strokes(stance)]


def _strokes(stance: Stance) -> list[tuple[Array, bool]]:
    """Runs of points on the scan, and single bridged points."""
    strokes: list[tuple[Array, bool]] = []
    for line in stance.lines:
        if not line.bridged.any():
            strokes.append((line.points, line.closed))
            continue
        for run, bridged in line.runs():
            strokes += [(point[None], False) for point in run[::2]] if bridged else [(run, False)]
    return strokes
