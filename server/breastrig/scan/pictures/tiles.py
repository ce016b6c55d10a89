"""Textures of several tiles, each with a picture of its own: UDIM (1001, 1002, ..., ten a row) and u1_v1, u2_v1, ...

Programs write a place for the tile in the picture's name (<UDIM>, <UVTILE>), or name the first tile's picture alone;
texture coordinates beyond one then lie on the next tile.  Without such pictures they mean one that is repeated.
"""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Integers
from breastrig.core.errors import TooLarge
from breastrig.scan.limits import MATERIALS
from breastrig.scan.pictures.companions import Companions
from breastrig.scan.piece import Piece, part

NUMBER = re.compile(r"<udim>|%\(udim\)d|(?<!\d)1\d{3}(?!\d)(?=[^/\\]*$)", re.IGNORECASE)
PAIR = re.compile(r"<uvtile>|(?<![^\W_])u\d{1,2}_v\d{1,2}(?!\d)(?=[^/\\]*$)", re.IGNORECASE)
FIRST, ACROSS = 1001, 10  # UDIM's first tile, and how many are in a row
BORDER = 1e-4  # of a tile's width, a pixel of the largest pictures: coordinates are rounded
ACROSS_BORDER = (
    "{count} triangles reach across the border of two tiles of the texture and are painted with one tile's picture; "
    "cut the texture there for exact colours."
)
MISSING = "The texture of this scan has several tiles, and not all of their pictures are beside it ({count} missing)."


def painted_by_tiles(piece: Piece, written: str, files: Companions) -> tuple[Piece, ...]:
    """The piece, which has coordinates, with the picture of this name; a piece for each tile where there are several.

    Faces without a picture have none; what became of it is noted.  TooLarge for more tiles than there may be materials.
    """
    name, has_place = _names(written, files)
    used, which = np.unique(_tiles(piece), axis=0, return_inverse=True)
    if has_place and len(used) > MATERIALS:
        raise TooLarge(f"The texture of this scan has more than the {MATERIALS} tiles allowed; join them.")
    names = [name(int(u), int(v)) for u, v in used[:MATERIALS]]
    pictures = [found if found and files.has_picture(found) else None for found in names]
    others = [picture for picture, tile in zip(pictures, used, strict=False) if picture and tile.any()]
    if not has_place and (not others or len(used) > MATERIALS):
        return (replace(piece, picture=files.picture(written)),)
    if None in pictures:
        files.note(MISSING.format(count=pictures.count(None)))
    if len(used) > 1 and (count := _crossing(piece, used[which.ravel()])):
        files.note(ACROSS_BORDER.format(count=count))
    return tuple(
        _on_tile(part(piece, which.ravel() == index), used[index], picture, files)
        for index, picture in enumerate(pictures)
    )


def _on_tile(piece: Piece, tile: Integers, picture: str | None, files: Companions) -> Piece:
    if picture is None or piece.uv is None:
        return replace(piece, uv=None)
    inside = np.clip(piece.uv - tile, 0.0, 1.0)  # a triangle that reaches onto the next tile is painted up to its edge
    return replace(piece, uv=inside, picture=files.picture(picture))


def _crossing(piece: Piece, tiles: Integers) -> int:
    """The number of triangles that reach beyond their (F, 2) tiles."""
    assert piece.uv is not None
    beyond = np.abs(piece.uv[piece.faces] - tiles[:, None] - 0.5) - 0.5  # NaN, without a place, is never more
    return int(np.count_nonzero((beyond > BORDER).any(axis=(1, 2))))


def _tiles(piece: Piece) -> Integers:
    """(F, 2) the tile on which the middle of each triangle lies; 0, 0 for those that have no place."""
    assert piece.uv is not None
    with np.errstate(all="ignore"):
        middle = np.floor(piece.uv[piece.faces].mean(axis=1))
    return np.asarray(np.nan_to_num(np.clip(middle, -1e6, 1e6)).astype(np.int64))


def _names(written: str, files: Companions) -> tuple[Callable[[int, int], str | None], bool]:
    """(the name of the picture of tile u, v or None, whether what is written has a place for the tile)."""
    found = next((last for pattern in (NUMBER, PAIR) for last in reversed(list(pattern.finditer(written)))), None)
    if found is None:
        return lambda u, v: None, False
    head, tail, is_number = written[: found.start()], written[found.end() :], found.re is NUMBER
    lowest = 0 if files.has_picture(f"{head}u0_v0{tail}") else 1

    def name(u: int, v: int) -> str | None:
        if u < 0 or v < 0 or (is_number and u >= ACROSS):
            return None
        tile = f"{FIRST + u + ACROSS * v}" if is_number else f"u{u + lowest}_v{v + lowest}"
        return f"{head}{tile}{tail}"

    return name, found[0][0] in "<%"
