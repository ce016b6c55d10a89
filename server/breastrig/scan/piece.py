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
class PointCloud:
    """N points without triangles."""

    points: Array  # (N, 3) the file's unit
    normals: Array | None = None  # (N, 3) of any length, to the side that was seen
    colours: NDArray[uint8] | None = None  # (N, 3) sRGB
    sensor: Array | None = None  # (3,) where it was seen from, the file's unit


@dataclass(frozen=True, eq=False)
class Pieces:
    """Everything that a file holds."""

    pieces: tuple[Piece, ...]
    has_points: bool = False  # beside the triangles, or instead of them
    notes: tuple[str, ...] = ()  # one sentence each
    cloud: PointCloud | None = None  # where there are points and no triangles at all
