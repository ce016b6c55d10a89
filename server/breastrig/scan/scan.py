"""A scan as it was read: the scanner's triangles in the scanner's own frame, in metres.

Nothing is cleaned, turned or moved here, so whatever is found on it can be given back in the same frame.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.core.errors import BadLandmarks
from breastrig.core.stances import Stance
from breastrig.scan.kept_image import KeptImage
from breastrig.scan.piece import BallInside, SeenLandmark, TakenSegment
from breastrig.scan.true_size import TrueSize


@dataclass(frozen=True, eq=False)
class Scan:
    """V vertices, F triangles."""

    vertices: Array  # (V, 3) m, the scan's own frame
    faces: Integers  # (F, 3)
    unit: str  # of the file: m, dm, cm, mm, in or ft
    metres_per_unit: float
    unit_reason: str  # one sentence
    sha256: str  # of the file's bytes
    notes: tuple[str, ...] = ()  # what reading found, one sentence each
    colours: NDArray[np.uint8] | None = None  # (V, 3) sRGB
    uv: Array | None = None  # (V, 2) origin at the lower left of the texture; only together with a texture
    texture: bytes | None = None  # a JPEG without metadata, small enough to be shown; else `picture` itself
    from_points: bool = False  # the file held points alone, and its triangles were laid through them
    cut_by_hand: int = 0  # triangles that a person has cut away; they are not among the faces
    picture: bytes | None = None  # behind it: the file's own JPEG or PNG, its pixels and nothing else

    from_label_map: bool = False  # whose axes are the patient's (LPS)
    from_image: bool = False  # whose axes are the patient's (LPS) too
    image: KeptImage | None = None  # of which the skin was made; kept beside a stored scan
    seen: tuple[SeenLandmark, ...] = ()  # that the image shows, m
    stated_stance: Stance | None = None  # by the image's header
    lesions: tuple[BallInside, ...] = ()  # that a label map shows, m
    wall: tuple[Array, Integers] | None = None  # (V, 3) m the chest wall that its file names, (F, 3) towards the front
    segments: tuple[TakenSegment, ...] = ()  # of a label map, and what each was taken for
    true_size: TrueSize | None = None  # that it was scaled to; None: it has the size of its file
    size_known: bool = True  # False: its file does not say how large the patient is (unscaled.py)

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices))
        object.__setattr__(self, "faces", frozen(self.faces, np.int64))
        if self.colours is not None:
            object.__setattr__(self, "colours", frozen(self.colours, np.uint8))
        if self.uv is not None:
            object.__setattr__(self, "uv", frozen(self.uv))

    @property
    def colour_kind(self) -> str:
        """ "texture", "vertex" or "none"."""
        return "texture" if self.texture is not None else "none" if self.colours is None else "vertex"

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The (3,) lowest and highest place, m."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @property
    def in_patient_frame(self) -> bool:
        """Whether its axes are the patient's: to the left, back and head (LPS)."""
        return self.from_label_map or self.from_image

    @property
    def measured(self) -> tuple[float, tuple[Array, Array]]:
        """The unit in m and the bounds, for places without a unit of their own."""
        return self.metres_per_unit, self.bounds

    def in_true_size(self, size: TrueSize) -> "Scan":
        """Scaled to its true size. Raises BadLandmarks for an image, whose file knows its own, and for a second one."""
        if self.in_patient_frame:
            raise BadLandmarks("An image has its true size already; leave the length out.")
        if self.true_size is not None:
            raise BadLandmarks("This scan has its true size already, by another length; leave this one out.")
        vertices, notes = size.factor * self.vertices, (*self.notes, size.note)
        return replace(self, vertices=vertices, notes=notes, true_size=size, size_known=True)

    @cached_property
    def shows_colour(self) -> bool:
        """Whether there is anything to see: many programs write one grey for all vertices of a scan without colours."""
        if self.colour_kind != "vertex" or self.colours is None:
            return self.colour_kind == "texture"
        return bool((self.colours != self.colours[:1]).any())
