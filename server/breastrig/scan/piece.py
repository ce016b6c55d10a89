"""The meshes of a scan file before they become one scan: scanner apps split their files by picture."""

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy import uint8
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.srgb import to_srgb
from breastrig.core.stances import Stance
from breastrig.scan.kept_image import KeptImage

SEVERAL = "The scan has several textures and is shown without them."
COLOURLESS = "This scan has no colour, so no ink can be seen on it; scan again with colour."
PARTLY_COLOURED = "Parts of this scan have no colour and are shown in grey."
UNCOLOURED = 190  # grey of what has no colour beside what has one: neither skin nor ink


@dataclass(frozen=True, eq=False)
class Piece:
    """V vertices where the file's scene puts them, F triangles that have been turned with them."""

    vertices: Array  # (V, 3) the file's unit
    faces: Integers  # (F, 3)
    colours: NDArray[uint8] | None = None  # (V, 3) sRGB
    uv: Array | None = None  # (V, 2) origin at the lower left of the picture
    picture: bytes | None = None  # JPEG or PNG
    tint: tuple[int, int, int] | None = None  # sRGB of its material where nothing else colours it


def part(piece: Piece, chosen: Booleans) -> Piece:
    """The piece with only the chosen (F,) triangles and the vertices that they use."""
    faces = piece.faces[chosen]
    used = np.zeros(len(piece.vertices), np.bool_)
    used[faces] = True
    return replace(
        piece,
        vertices=piece.vertices[used],
        faces=(np.cumsum(used) - 1)[faces],
        colours=None if piece.colours is None else piece.colours[used],
        uv=None if piece.uv is None else piece.uv[used],
    )


@dataclass(frozen=True, eq=False)
class PointCloud:
    """N points without triangles."""

    points: Array  # (N, 3) the file's unit
    normals: Array | None = None  # (N, 3) of any length, to the side that was seen
    colours: NDArray[uint8] | None = None  # (N, 3) sRGB
    sensor: Array | None = None  # (3,) where it was seen from, the file's unit


@dataclass(frozen=True, eq=False)
class BallInside:
    """A lesion that a label map shows."""

    name: str
    center: Array  # (3,) the file's unit
    radius: float


@dataclass(frozen=True, eq=False)
class SeenLandmark:
    """A landmark that an image shows."""

    name: str
    place: Array  # (3,) the file's unit
    radius: float  # that holds the true place with 90 %


@dataclass(frozen=True)
class TakenSegment:
    """A segment of a label map with how it is used."""

    number: int  # in the file
    name: str  # "Lesion 1", "Tissue 2": none of the file's words, which may be the patient's name
    taken_as: Literal["lesion", "tissue", "unused"]
    why: str  # one sentence
    radius_mm: float | None = None  # of a lesion, of its largest part
    label: str = field(default="", repr=False)  # the file's own words: to be shown while choosing, and never kept


@dataclass(frozen=True, eq=False)
class Pieces:
    """The whole contents of a file."""

    pieces: tuple[Piece, ...]
    has_points: bool = False  # beside the triangles, or instead of them
    notes: tuple[str, ...] = ()  # one sentence each
    cloud: PointCloud | None = None  # where there are points and no triangles at all
    unit: str | None = None  # that the file names
    unit_by_default: bool = False  # that its format means where a file names none
    is_unscaled: bool = False  # of a program whose scans have a size that nobody has measured (unscaled.py)
    is_label_map: bool = False
    lesions: tuple[BallInside, ...] = ()
    segments: tuple[TakenSegment, ...] = ()
    wall: tuple[Array, Integers] | None = None  # (V, 3) the chest wall that a volume names, (F, 3) towards the front
    image: KeptImage | None = None  # of which the skin was made
    seen: tuple[SeenLandmark, ...] = ()  # that it shows
    stance: Stance | None = None  # that its header states


def colour_bytes(values: Array, largest: float | None = None) -> NDArray[uint8]:
    """(N, 3) sRGB of colours up to `largest`, or without it up to 1, 255 or 65,535, whichever holds all of them."""
    sound = np.nan_to_num(values, posinf=0.0, neginf=0.0)
    if largest is None:
        most = float(sound.max(initial=0.0))
        largest = 1.0 if most <= 1.0 else 255.0 if most <= 255.0 else 65535.0
    return np.asarray(np.round(255.0 * np.clip(sound / largest, 0.0, 1.0)).astype(np.uint8))


def srgb_bytes(linear: NDArray[Any]) -> NDArray[uint8]:
    """(V, 3) sRGB of linear light: floats from 0 to 1, or whole numbers up to their maximum; an opacity is dropped."""
    full = 1.0 if linear.dtype.kind == "f" else float(np.iinfo(linear.dtype).max)
    return np.asarray(np.round(255.0 * to_srgb(np.nan_to_num(linear[:, :3] / full))).astype(np.uint8))
