"""A small picture of a fit, for notebooks."""

import io

from PIL import Image

from breastrig.interface.one_thread import one_thread
from breastrig.rendering.picture import Layer, Scene, diverging_colours
from breastrig.report.pictures import views_of
from breastrig.workflow.folder.fit_folder import FitFolder
from breastrig.workflow.report import stance_of

SIZE = (300, 360)  # pixels
LIMIT_MM = 5.0  # where the colours end: blue inside the scan's skin, orange outside


def picture_png(found: FitFolder) -> bytes:
    """PNG of the fitted model from the front, coloured by its signed distance to the scan."""
    with one_thread():
        stance = stance_of(found)
        [view] = views_of(stance, ("front",), SIZE[0] / SIZE[1])
        colours = diverging_colours(1e3 * stance.distances, LIMIT_MM)
        picture = Scene([Layer(stance.vertices, stance.rig.faces, colours)]).render(view, SIZE)
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "PNG")
    return stream.getvalue()
