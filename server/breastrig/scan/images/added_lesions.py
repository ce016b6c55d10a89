"""Lesions of another file than the scan's: those that are there already are not taken twice, the others numbered on."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.scan.piece import BallInside, TakenSegment

SAME = 0.1  # mm by which centre and radius of one lesion differ between two readings of its file
NO_IMAGE = (
    "This scan was made of no image, so it is not known where lesions of another file lie in it; upload the image that "
    "they were drawn on, and give them with that."
)
NUMBERED = re.compile(r"Lesion (\d+)")


@dataclass(frozen=True, eq=False)
class LesionsRead:
    """What a file shows in the frame of the image that it was drawn on."""

    lesions: tuple[BallInside, ...]  # mm, LPS
    segments: tuple[TakenSegment, ...]
    notes: tuple[str, ...]  # one sentence each
    wall: tuple[Array, Integers] | None = None  # (V, 3) mm, LPS, of the chest wall, and (F, 3) towards the front


@dataclass(frozen=True, eq=False)
class TakenLesion(BallInside):
    """A lesion of a file under the name that it has with the scan; mm."""

    is_new: bool  # false: it was there before


@dataclass(frozen=True, eq=False)
class TakenLesions:
    """The lesions of one file."""

    lesions: tuple[TakenLesion, ...]
    segments: tuple[TakenSegment, ...]
    notes: tuple[str, ...]  # what reading found, one sentence each


def taken(
    found: Sequence[BallInside],
    segments: Sequence[TakenSegment],
    notes: Sequence[str],
    known: Sequence[BallInside],
    names_taken: Collection[str] = (),
) -> TakenLesions:
    """`found`, numbered on after the `known` lesions and others of those names; one that is known keeps its name.

    All are in mm of one frame.
    """
    matches = (NUMBERED.match(name) for name in (*names_taken, *(one.name for one in known)))
    last, names = max((int(match[1]) for match in matches if match), default=0), dict[str, str]()
    lesions = list[TakenLesion]()
    for each in found:
        whole, comma, part = each.name.partition(",")
        twin = next((one for one in (*known, *lesions) if _is_same(one, each)), None)
        if twin is not None:
            names.setdefault(whole, twin.name.partition(",")[0])
            lesions.append(TakenLesion(twin.name, twin.center, twin.radius, False))
            continue
        if whole not in names:
            last += 1
            names[whole] = f"Lesion {last}"
        lesions.append(TakenLesion(f"{names[whole]}{comma}{part}", each.center, each.radius, True))
    called = tuple(replace(each, name=names.get(each.name, each.name)) for each in segments)
    return TakenLesions(tuple(lesions), called, tuple(notes))


def _is_same(one: BallInside, other: BallInside) -> bool:
    return abs(one.radius - other.radius) < SAME and float(np.linalg.norm(one.center - other.center)) < SAME
