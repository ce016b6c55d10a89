"""A texture with nothing in it but what some triangles show: all other pixels get one colour.

So what was cut out of a scan is gone from its picture too, where anybody who has the file could look at it.
"""

import io

import numpy as np

from breastrig.core.arrays import Array

BORDER = 2  # pixels around the triangles: what the next coarser picture of a mipmap mixes with theirs
QUALITY = 92  # of the JPEG: it is the second time that it is written, and pen strokes are thin


def covered_texture(picture: bytes, corners: Array) -> bytes:
    """The JPEG of a picture's pixels under the triangles: (F, 3, 2) corners, origin at the lower left, repeating."""
    from PIL import Image, ImageDraw, ImageFilter  # half a tenth of a second, and few scans come this way

    with Image.open(io.BytesIO(picture), formats=("PNG", "JPEG")) as opened:
        pixels = np.array(opened.convert("RGB"))
    height, width = pixels.shape[:2]
    mask = Image.new("L", (width, height), 0)
    draw = ImageDraw.Draw(mask)
    tiles = corners - np.floor(corners.min(axis=1, keepdims=True))  # they begin in the first repetition
    for right, up in ((0, 0), (1, 0), (0, 1), (1, 1)):
        there = tiles - [right, up]
        seen = there[(there.max(axis=1) >= 0.0).all(axis=1)]
        places = np.stack((seen[..., 0] * width, (1.0 - seen[..., 1]) * height), axis=-1) - 0.5
        for triangle in np.clip(places, -2.0 * max(width, height), 3.0 * max(width, height)).reshape(-1, 6).tolist():
            draw.polygon(triangle, fill=255, outline=255)
    shown = np.asarray(mask.filter(ImageFilter.MaxFilter(2 * BORDER + 1))) > 0
    if shown.any():
        pixels[~shown] = np.round(pixels[shown].mean(axis=0))
    else:
        pixels[:] = 0
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=QUALITY, subsampling=0)
    return stream.getvalue()
