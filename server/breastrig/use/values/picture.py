"""Pictures of fits and bodies without a display, for programs."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from breastrig.core.arrays import Array
from breastrig.core.one_thread import one_thread
from breastrig.core.units import METRES_PER_UNIT
from breastrig.rendering.picture import NEUTRAL, Layer, Scene, camera, diverging_colours
from breastrig.rendering.picture import Line as DrawnLine
from breastrig.report.body_frame import body_frame
from breastrig.report.pictures import line_colour, uncertainty_colours
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder
from breastrig.use.reports.report import stance_of
from breastrig.use.values.drawing import Line

LIMIT_MM = 5.0  # where the colours of distances end: blue inside the scan's skin, orange outside


def fit_picture(
    found: FitFolder,
    view: str,
    show: Literal["distances", "uncertainty", "model", "scan"],
    lines: Sequence[Line],
    size: tuple[int, int],
) -> Image.Image:
    """The picture of `Fit.picture`; points of the lines are in the fit's unit."""
    with one_thread():
        surface = Layer(found.vertices, found.rig.faces)
        if show == "scan":
            surface = Layer(found.surface.vertices, found.surface.faces)
        elif show == "distances":
            distances = 1e3 * stance_of(found).distances
            surface = Layer(found.vertices, found.rig.faces, diverging_colours(distances, LIMIT_MM))
        elif show == "uncertainty":
            radii = np.full(len(found.vertices), np.nan) if found.radii is None else 1e3 * found.radii
            surface = Layer(found.vertices, found.rig.faces, uncertainty_colours(radii))
        frame = body_frame(found.rig, found.vertices).axes
        drawn = [
            DrawnLine(
                found.metres_per_unit * np.asarray(line.points), line_colour(line.color), size[1] / 200.0, line.closed
            )
            for line in lines
        ]
        eye = camera(view, found.vertices, frame, size[0] / size[1])
        return Image.fromarray(Scene([surface]).render(eye, size, drawn))


def body_picture(
    rig: Rig, vertices: Array, unit: str, view: str, colours: ArrayLike | None, size: tuple[int, int]
) -> Image.Image:
    """The picture of `Rig.picture`."""
    with one_thread():
        places = METRES_PER_UNIT[unit] * np.asarray(vertices, dtype=np.float64)
        eye = camera(view, places, body_frame(rig, places).axes, size[0] / size[1])
        layer = Layer(places, rig.faces, NEUTRAL if colours is None else np.asarray(colours, dtype=np.float64))
        return Image.fromarray(Scene([layer]).render(eye, size))
