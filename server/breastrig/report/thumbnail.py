"""A small picture of a scan, for lists: from the front, in one grey, so that it shows no more than it must."""

import io
from typing import Any

import numpy as np
from PIL import Image

from breastrig.rendering.picture import Layer, camera, render
from breastrig.scan.clean import Surface

SIZE = (144, 180)  # pixels: sharp at 72 x 90 on a fine screen


def thumbnail_png(surface: Surface, body_frame: dict[str, Any]) -> bytes:
    """PNG of a cleaned scan; `body_frame` has its up and front (unit, the scan's axes)."""
    up, front = (np.asarray(body_frame[name], dtype=np.float64) for name in ("up", "front"))
    frame = np.stack([np.cross(up, front), up, front], axis=1)
    view = camera("front", surface.vertices, frame, SIZE[0] / SIZE[1])
    picture = render([Layer(surface.vertices, surface.faces)], view, SIZE, background=None)
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "PNG", optimize=True)
    return stream.getvalue()
