"""A label map as read: segments on one grid of voxels, and the possible frames of that grid."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import LABEL_MAP_VOXELS
from breastrig.scan.volumes.answers import TakenAs

Box = tuple[slice, slice, slice]

NOT_GREY = (
    "This file holds no single grey value or label for each voxel (colours, vectors?); export an image or a label map."
)
SMALLEST_VOXEL, LARGEST_VOXEL = 0.05, 50.0  # mm; a breast MRI has 0.3 to 5
FRAME_DIGITS = 16
FLAT = 0.1  # volume of a voxel over that of a box with its edges; a scanner that leans by 30 degrees has 0.87


@dataclass(frozen=True, eq=False)
class Segment:
    """One structure; segments may overlap."""

    number: int
    box: Box  # that holds all of it
    count: int  # voxels
    inside: Callable[[], Booleans]  # (of the box's shape) its voxels; made anew at every call
    label: str = field(default="", repr=False)  # the file's own words
    coded: TakenAs | None = None  # what its codes say


@dataclass(frozen=True, eq=False)
class Reading:
    """A possible frame of the voxels."""

    value: str  # of the answer `frame`
    text: str  # what that means
    affine: Array  # (4, 4) voxel indices to mm, LPS
    is_placed: bool = True  # whether the file says where, not only how the axes run


@dataclass(frozen=True)
class Gap:
    """Slices of which nothing is known."""

    axis: int
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Volume:
    """All segments; their voxels lie as one of the readings states."""

    shape: tuple[int, int, int]
    segments: tuple[Segment, ...]
    readings: tuple[Reading, ...]
    doubt: str = ""  # why there are several
    notes: tuple[str, ...] = ()
    gaps: tuple[Gap, ...] = ()
    frame: str = ""  # digest of the file's frame of reference; empty where it names none


def frame_digest(uid: str) -> str:
    """The digest of a frame of reference's UID, by which two files of one frame are known; empty without one."""
    return hashlib.sha256(uid.encode()).hexdigest()[:FRAME_DIGITS] if uid else ""


def check_shape(shape: tuple[int, ...]) -> None:
    """Raises BadScan or TooLarge for a shape that is not supported."""
    if len(shape) < 3 or any(size != 1 for size in shape[3:]):
        raise BadScan("This file must be one volume of three dimensions; export it as one.")
    if min(shape[:3]) < 2:
        raise BadScan("This file is a single slice; export the whole volume.")
    if np.prod(shape[:3], dtype=np.float64) > LABEL_MAP_VOXELS:
        raise TooLarge(f"This volume has more than the {LABEL_MAP_VOXELS:,} voxels allowed; resample it first.")


def check_affine(affine: Array) -> None:
    """Raises BadScan for voxels of no size, or of one that no image of a body has."""
    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    if not np.isfinite(affine).all() or not sizes.all() or abs(np.linalg.det(affine[:3, :3] / sizes)) < FLAT:
        raise BadScan("This file does not say where its voxels lie; export it again.")
    if not (sizes.min() >= SMALLEST_VOXEL and sizes.max() <= LARGEST_VOXEL):
        shown = " x ".join(f"{size:.3g}" for size in sizes)
        raise BadScan(f"The voxels of this file are {shown} mm, which those of no body are; check its unit.")
