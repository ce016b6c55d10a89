"""Several pictures of one scan as one: scanner apps write a picture for each part of what they saw.

All pictures are laid on one sheet, the highest first, in rows, and texture coordinates are moved there; everything
that comes later then knows one picture.  Between them the borders are repeated, so that none is mixed into another.
A sheet that would be larger than any texture may be is made of pictures scaled down by whole pixels.

A part without a picture, as scanner apps leave what the camera did not see, is painted in one colour.
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan
from breastrig.scan.limits import IMAGE_PIXELS, TEXTURE_SIDE
from breastrig.scan.pictures.texture import opened, pixels_of
from breastrig.scan.piece import UNCOLOURED, Piece

BORDER = 2  # pixels around each picture; mixing neighbours needs one
QUALITY = 95  # JPEG with whole colours: thin lines of ink stay what they are
BEYOND = 1e-4  # of a picture's side, by which coordinates may lie outside of it
TOO_MANY = (
    f"The textures of this scan have more than {IMAGE_PIXELS // 10**6} million pixels together and were left out; "
    "scale them down first."
)
REPEATED = "The scan has several textures, some laid out as repeated tiles, and is shown without them."
DAMAGED = "One of the textures of this scan is damaged, and all were left out."
UNPAINTED = "Parts of this scan have no texture and are shown in one colour."


@dataclass(frozen=True)
class _Cell:
    """A picture's rectangle on the sheet, pixels."""

    left: int
    top: int
    width: int
    height: int


def joined_textures(pieces: Sequence[Piece]) -> tuple[bytes | None, Array, str | None]:
    """(JPEG of all pictures, (V, 2) coordinates of all pieces on it, None), or (None, ..., why it cannot be).

    At least one piece has a picture; each that has one has coordinates.
    """
    painted = [
        piece if piece.picture is not None and piece.uv is not None else _in_one_colour(piece) for piece in pieces
    ]
    uv = np.concatenate([piece.uv for piece in painted if piece.uv is not None])
    if not np.isfinite(uv).all() or (uv < -BEYOND).any() or (uv > 1.0 + BEYOND).any():
        return None, uv, REPEATED
    pictures = list(dict.fromkeys(piece.picture for piece in painted if piece.picture is not None))
    try:
        sizes = [_size(picture) for picture in pictures]
        if sum(width * height for width, height in sizes) > IMAGE_PIXELS:
            return None, uv, TOO_MANY
        cells, sheet, factor = _laid_out(sizes)
        pixels = np.zeros((sheet[1], sheet[0], 3), dtype=np.uint8)
        for picture, cell in zip(pictures, cells, strict=True):
            _paint(pixels, _reduced(pixels_of(picture), cell, factor), cell)
    except BadScan:
        return None, uv, DAMAGED
    moved = []
    for piece in painted:
        assert piece.uv is not None
        assert piece.picture is not None
        cell = cells[pictures.index(piece.picture)]
        inside = np.clip(piece.uv, 0.0, 1.0)
        across = (cell.left + inside[:, 0] * cell.width) / sheet[0]
        down = (cell.top + (1.0 - inside[:, 1]) * cell.height) / sheet[1]
        moved.append(np.stack([across, 1.0 - down], axis=1))
    return _written(pixels), np.concatenate(moved), None


def _in_one_colour(piece: Piece) -> Piece:
    """The piece with a picture of one pixel: the mean colour of its vertices, its material's colour, or grey."""
    from PIL import Image  # as below

    colour = piece.tint or (UNCOLOURED, UNCOLOURED, UNCOLOURED)
    if piece.colours is not None and len(piece.colours):
        red, green, blue = (round(float(each)) for each in piece.colours.mean(axis=0))
        colour = (red, green, blue)
    stream = io.BytesIO()
    Image.new("RGB", (1, 1), colour).save(stream, "PNG")
    return replace(piece, uv=np.full((len(piece.vertices), 2), 0.5), picture=stream.getvalue())


def _size(picture: bytes) -> tuple[int, int]:
    with opened(picture) as found:
        return found.size


def _laid_out(sizes: Sequence[tuple[int, int]]) -> tuple[list[_Cell], tuple[int, int], int]:
    """(A cell for each of these widths and heights, the sheet's width and height, what they are divided by)."""
    factor = 1
    while True:
        small = [(-(-width // factor), -(-height // factor)) for width, height in sizes]
        cells, sheet = _rows(small)
        if max(sheet) <= TEXTURE_SIDE:
            return cells, sheet, factor
        factor += 1


def _rows(sizes: Sequence[tuple[int, int]]) -> tuple[list[_Cell], tuple[int, int]]:
    area = sum((width + 2 * BORDER) * (height + 2 * BORDER) for width, height in sizes)
    longest = max(max(width for width, _ in sizes) + 2 * BORDER, int(np.ceil(np.sqrt(area))))
    cells: dict[int, _Cell] = {}
    left = top = row = right = 0
    for number in sorted(range(len(sizes)), key=lambda each: -sizes[each][1]):
        width, height = sizes[number]
        if left + width + 2 * BORDER > longest:
            left, top, row = 0, top + row, 0
        cells[number] = _Cell(left + BORDER, top + BORDER, width, height)
        left, row = left + width + 2 * BORDER, max(row, height + 2 * BORDER)
        right = max(right, left)
    return [cells[number] for number in range(len(sizes))], (right, top + row)


def _reduced(pixels: NDArray[np.uint8], cell: _Cell, factor: int) -> NDArray[np.uint8]:
    if factor == 1 and pixels.shape[:2] == (cell.height, cell.width):
        return pixels
    from PIL import Image  # as above

    return np.asarray(Image.fromarray(pixels).resize((cell.width, cell.height), Image.Resampling.BOX))


def _paint(sheet: NDArray[np.uint8], pixels: NDArray[np.uint8], cell: _Cell) -> None:
    bordered = np.pad(pixels, ((BORDER, BORDER), (BORDER, BORDER), (0, 0)), mode="edge")
    top, left = cell.top - BORDER, cell.left - BORDER
    sheet[top : top + bordered.shape[0], left : left + bordered.shape[1]] = bordered


def _written(pixels: NDArray[np.uint8]) -> bytes:
    from PIL import Image  # as above

    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=QUALITY, subsampling=0)
    return stream.getvalue()
