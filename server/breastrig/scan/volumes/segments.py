"""Classifies each segment of a label map: a lesion, or tissue.

A person's word counts, then the segment's codes, then its form: what is small, compact and inside the body is a lesion,
in any language. Words of the file are only a hint, for a lesion that is not compact or reaches the skin.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan, BadSettings
from breastrig.scan.limits import LABEL_MAP_VOXELS
from breastrig.scan.piece import BallInside, TakenSegment
from breastrig.scan.volumes.answers import TakenAs
from breastrig.scan.volumes.volume import Box, Segment, Volume

LARGEST_LESION = 40.0  # mm radius of what only its form says is a lesion; what is larger is tissue
LARGEST_NAMED = 80.0  # mm radius, as a plan takes it
SMALLEST_LESION = 1.0  # mm radius; less is noise
LESIONS = 20
MOST_CHARACTERS = 100  # of a list of numbers in a sentence
COMPACT = 0.4  # share of the ellipsoid in its bounding box that a lesion fills; vessels and glands fill less
LONGEST = 3.0  # extent over the diameter of a ball as large; four times as long as broad has 2.5, a wire far more
LOOKED_AT = 4 * LABEL_MAP_VOXELS  # voxels of all segments' boxes together, about 20 s of work
HINT = re.compile(
    r"lesi|lasion|tumou?r|tumeur|mass\b|neoplas|cancer|krebs|carcinom|karzinom|malign|cyst|zyste|fibroadenom|nodul|"
    r"knoten|\bherd|\bdcis|\bgtv",
    re.IGNORECASE,
)

WALL = re.compile(
    r"pectoral|\bmuscles?\b|\bmuscul|muskel|chest[ _-]?wall|thora(?:x|cic)[ _-]?wall|brust(?:korb)?wand|thoraxwand|"
    r"paroi thorac",
    re.IGNORECASE,
)
NO_WALL = re.compile(r"node|knoten|ganglion|implant|prothes", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Taken:
    """The use of all segments."""

    segments: tuple[TakenSegment, ...]
    lesions: tuple[BallInside, ...]  # centres in voxel indices, radii in mm


@dataclass(frozen=True, eq=False)
class _Part:
    """A connected part of a segment."""

    centre: Array  # (3,) voxel indices
    radius: float  # mm, of a ball with as many voxels
    fills: float  # of the ellipsoid in its bounding box
    longest: float  # its longest extent, over the diameter of that ball


def names_wall(label: str) -> bool:
    """Whether a segment's words say pectoral muscle or chest wall."""
    return bool(WALL.search(_plain(label))) and not NO_WALL.search(_plain(label))


def check_chosen(volume: Volume, chosen: Mapping[int, TakenAs]) -> None:
    """Raises BadSettings where an answer names a segment that does not exist."""
    known = [each.number for each in volume.segments]
    for number in chosen:
        if number not in known:
            there = ", ".join(map(str, known[:20])) or "none"
            raise BadSettings(f"There is no segment {number} in this file; it has {there}.")


def taken_segments(
    volume: Volume,
    body: Callable[[Box], Booleans],
    affine: Array,
    chosen: Mapping[int, TakenAs],
    are_lesions_alone: bool = False,
) -> Taken:
    """Each segment with its use, and the lesions.

    `body` says of a box of voxels which are not air, `affine` (4, 4) leads to mm; of `are_lesions_alone` the largest
    segment may be one, and the only one is. Raises BadScan for too many lesions, and where a
    segment that a person calls a lesion can be none.
    """
    most = 0 if are_lesions_alone else max((each.count for each in volume.segments), default=0)
    is_only = are_lesions_alone and len(volume.segments) == 1
    steps = np.linalg.norm(affine[:3, :3], axis=0)
    cell = abs(float(np.linalg.det(affine[:3, :3])))
    work = LOOKED_AT
    taken: list[TakenSegment] = []
    lesions: list[BallInside] = []
    count: Counter[str] = Counter()
    for each in sorted(volume.segments, key=lambda each: each.number):
        size = int(np.prod([side.stop - side.start for side in each.box], dtype=np.float64))
        is_largest, is_looked_at, said = each.count == most, size <= work, chosen.get(each.number)
        what, why, parts = _decided(each, said, body, cell, steps, is_largest, is_looked_at, is_only)
        work -= size if parts is not None else 0
        count[what] += 1
        name = {
            "lesion": f"Lesion {count[what]}",
            "tissue": f"Tissue {count[what]}",
            "unused": f"Unused {count[what]}",
        }[what]
        radius = max((part.radius for part in parts or ()), default=None) if what == "lesion" else None
        taken.append(TakenSegment(each.number, name, what, why, radius, each.label))
        for number, part in enumerate(parts or () if what == "lesion" else (), 1):
            whole = name if parts is None or len(parts) == 1 else f"{name}, part {number}"
            lesions.append(BallInside(whole, part.centre, part.radius))
    if len(lesions) > LESIONS and not are_lesions_alone:
        numbers = ", ".join(str(each.number) for each in taken if each.taken_as == "lesion")[:MOST_CHARACTERS]
        raise BadScan(
            f"This file has more than {LESIONS} lesions, of its segments {numbers}; say of those that are none "
            "what they are, such as 2=tissue."
        )
    return Taken(tuple(taken), tuple(lesions))


def _decided(
    segment: Segment,
    said: TakenAs | None,
    body: Callable[[Box], Booleans],
    cell: float,
    steps: Array,
    is_largest: bool,
    is_looked_at: bool,
    is_only: bool,
) -> tuple[TakenAs, str, list[_Part] | None]:
    """The segment's use, the reason, and its parts where they were examined."""
    if said in ("tissue", "unused"):
        return said, "A person said so.", None
    is_hinted = segment.coded is None and bool(HINT.search(_plain(segment.label)))
    is_large = bool(_radius(cell * segment.count) >= LARGEST_LESION)
    is_wall = segment.coded is None and not is_hinted and names_wall(segment.label)
    is_only = is_only and segment.coded is None and not is_large and not is_wall
    is_named = said == "lesion" or segment.coded == "lesion" or is_hinted or is_only
    if not is_named:
        if segment.coded is not None:
            return segment.coded, "Its codes say so.", None
        if is_wall:
            return "tissue", "Its name says so.", None
        if is_largest:
            return "tissue", "It is the largest segment.", None
        if is_large:
            return "tissue", f"It is larger than a ball of {2 * LARGEST_LESION:.0f} mm.", None
    if not is_looked_at and said is None:
        return "tissue", "It is scattered through the whole volume.", None
    inside = segment.inside()
    parts = _parts(inside, segment.box, cell, steps)
    fitting = [part for part in parts if part.radius <= LARGEST_NAMED]
    if is_named:
        too = "large" if parts else "small"
        if fitting:
            why = (
                "Its codes say so."
                if segment.coded
                else "Its name says so."
                if is_hinted
                else "It is the only segment."
            )
            return "lesion", "A person said so." if said else why, fitting
        if said:
            limit = f"{2 * (LARGEST_NAMED if parts else SMALLEST_LESION):.0f} mm"
            raise BadScan(
                f"Segment {segment.number} can be no lesion: it is {'more' if parts else 'less'} than {limit} across; "
                "take it for tissue, or leave it unused."
            )
        return "tissue", f"It is too {too} for a lesion.", parts
    if not parts:
        return "tissue", "It is too small for a lesion.", parts
    if not all(part.fills >= COMPACT and part.longest <= LONGEST for part in parts):
        return "tissue", "It is not compact as a lesion is.", parts
    if not _lies_inside(inside, segment.box, body):
        return "tissue", "It reaches the skin.", parts
    return "lesion", "It is small, compact and inside the body.", parts


def _parts(inside: Booleans, box: Box, cell: float, steps: Array) -> list[_Part]:
    """The segment's connected parts, without noise."""
    numbers: NDArray[Any]
    numbers, count = ndimage.label(inside)
    radii = _radius(cell * np.bincount(numbers.ravel(), minlength=count + 1))
    corner = np.array([side.start for side in box], np.float64)
    found = []
    for number, around in enumerate(ndimage.find_objects(numbers), 1):
        if around is None or radii[number] < SMALLEST_LESION:
            continue
        part = numbers[around] == number
        centre = corner + [side.start for side in around] + ndimage.center_of_mass(part)
        longest = float((steps * part.shape).max()) / (2.0 * radii[number])
        found.append(_Part(centre, float(radii[number]), float(part.mean()) / (np.pi / 6.0), longest))
    return found


def _lies_inside(inside: Booleans, box: Box, body: Callable[[Box], Booleans]) -> bool:
    """Whether nothing of it borders on air."""
    first, second, third = (slice(max(0, side.start - 1), side.stop + 1) for side in box)
    wider = (first, second, third)
    inner = ndimage.binary_erosion(body(wider), border_value=1)
    there = tuple(slice(side.start - more.start, side.stop - more.start) for side, more in zip(box, wider, strict=True))
    return bool(inner[there][inside].all())


def _radius(volumes: NDArray[Any] | float) -> NDArray[np.float64]:
    """Radii of balls of these volumes."""
    return np.cbrt(np.asarray(volumes) * 3.0 / (4.0 * np.pi))


def _plain(text: str) -> str:
    """The text without accents."""
    return "".join(each for each in unicodedata.normalize("NFKD", text) if not unicodedata.combining(each))
