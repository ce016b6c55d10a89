"""One mesh of a scan file, before all of them become one scan: scanner apps split what they write by picture."""

from dataclasses import dataclass

from numpy import uint8
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers

SEVERAL = "The scan has several textures and is shown without them."


@dataclass(frozen=True, eq=False)
class Piece:
    """V vertices where the file's scene puts them, F triangles that have been turned with them."""

    vertices: Array  # (V, 3) the file's unit
    faces: Integers  # (F, 3)
    colours: NDArray[uint8] | None = None  # (V, 3) sRGB
    uv: Array | None = None  # (V, 2) origin at the lower left of the picture
    picture: bytes | None = None  # JPEG or PNG, as it is in the file


@dataclass(frozen=True, eq=False)
class Pieces:
    """Everything that a file holds."""

    pieces: tuple[Piece, ...]
    has_points: bool = False  # beside the triangles, or instead of them
    notes: tuple[str, ...] = ()  # one sentence each
