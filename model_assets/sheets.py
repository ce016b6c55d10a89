"""Pictures side by side, saved."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from breastrig.rendering.picture import Picture


def save_png(picture: Picture, path: Path) -> None:
    """Writes a picture."""
    Image.fromarray(picture).save(path, optimize=True)


def contact_sheet(pictures: Sequence[Picture], columns: int, labels: Sequence[str] = ()) -> Picture:
    """Pictures of one size side by side, row by row, each with its label in the upper left corner."""
    height, width, depth = pictures[0].shape
    rows = -(-len(pictures) // columns)
    sheet = np.full((rows * height, columns * width, depth), 255, dtype=np.uint8)
    for place, picture in enumerate(pictures):
        row, column = divmod(place, columns)
        sheet[row * height : (row + 1) * height, column * width : (column + 1) * width] = picture
    image = Image.fromarray(sheet)
    pen = ImageDraw.Draw(image)
    for place, label in enumerate(labels):
        row, column = divmod(place, columns)
        pen.text((column * width + 8, row * height + 6), label, fill=(40, 44, 52), font_size=max(12, height // 32))
    return np.asarray(image)
