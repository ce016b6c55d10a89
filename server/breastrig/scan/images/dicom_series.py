"""Volumes of the slices that DICOM files hold: each with its own places, none squeezed, sheared or interleaved.

Slices of one volume are of one series, lie in parallel, have one size of pixels, and are of one phase, echo and kind.
Places come from ImagePositionPatient alone, for files' names and numbers say nothing of them.
"""

import hashlib
from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.images.dicom_headers import Slice
from breastrig.scan.limits import IMAGE_STACKS, IMAGE_VOXELS
from breastrig.scan.volumes.slices import gaps_said, runs
from breastrig.scan.volumes.volume import FLAT, LARGEST_VOXEL, SMALLEST_VOXEL, Gap

FEWEST = 8  # slices; fewer are no volume of a breast
ALIKE = 1e-3  # of direction cosines, and of pixel sizes in their own size
SAME_PLACE = 0.05  # mm
FARTHEST_OFF = 0.1  # of the distance between slices that one may lie off its place
MOST_MISSING = 0.25  # of the slices; with more their distance is unclear
LEANS = 1.0  # degrees of a stack that are said
WIDE = 3.0  # times the distance between slices: a gap that may divide two volumes
ROUNDED = 0.01  # of direction cosines' length, and their product
DIGITS = 8  # of a value
MANY = "These DICOM files hold far too many groups of slices; give one series alone."
NO_DIRECTION = "This DICOM series does not say how its slices lie; export it again."
TOO_FEW = (
    f"These DICOM images are fewer than {FEWEST} slices of one volume; give the folder or a zip of the whole series."
)
UNEVEN = "The slices of this DICOM series are unevenly spaced; export the series again, or resample it."
TWICE = (
    "Several DICOM images of this series lie on one place, and their headers do not say which belong together; export "
    "one volume alone."
)
APART: tuple[Callable[[Slice], Hashable], ...] = (  # what may tell pictures of one place
    lambda each: each.perhaps[0],
    lambda each: each.kind,
    lambda each: each.instance if each.frames > 1 else "",
    lambda each: each.perhaps[1],
)


@dataclass(frozen=True, eq=False)
class Stack:
    """Slices of one volume, in order."""

    slices: tuple[Slice, ...]
    index: Integers  # (N,) the place of each in the volume
    affine: Array  # (4, 4) column, row and slice to mm, LPS
    value: str  # of the answer `series`; digits that say nothing of the patient
    part: str = ""  # which of several volumes of one series
    notes: tuple[str, ...] = ()
    bridged: tuple[int, ...] = ()  # single slices that are missing between others
    gaps: tuple[Gap, ...] = ()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Columns, rows, slices."""
        first = self.slices[0]
        return first.columns, first.rows, int(self.index[-1]) + 1


@dataclass
class Found:
    """The volumes of some files, and why others are none."""

    stacks: list[Stack] = field(default_factory=list)
    faults: list[BadScan | TooLarge] = field(default_factory=list)  # of what is large enough to be meant
    small: int = 0  # groups of a few slices, and localizers


def stacks_of(slices: Iterable[Slice]) -> Found:
    """All volumes.  TooLarge for far too many."""
    found = Found()
    for group in _grouped(slices):
        parts, copies = _parts(group)
        if len(parts[0]) < FEWEST or _is_localizer(group[0]):
            found.small += 1
            continue
        for part in parts:
            try:
                found.stacks += _stacks(part, copies)
            except (BadScan, TooLarge) as error:
                found.faults.append(error)
    if len(found.stacks) > IMAGE_STACKS:
        raise TooLarge(MANY)
    found.stacks.sort(key=lambda each: _order(each.slices[0]))
    count = Counter(each.slices[0].series for each in found.stacks)
    seen: Counter[str] = Counter()
    for at, each in enumerate(found.stacks):
        series = each.slices[0].series
        seen[series] += 1
        if count[series] > 1:
            found.stacks[at] = replace(each, part=f"volume {seen[series]} of {count[series]} of this series")
    return found


def _order(first: Slice) -> tuple[Any, ...]:
    return first.number, first.series, first.varied, first.perhaps, first.kind, first.instance, first.place


def _is_localizer(one: Slice) -> bool:
    return any("LOCALIZER" in each.upper() for each in one.kind)


def _grouped(slices: Iterable[Slice]) -> list[list[Slice]]:
    """By series, frame of reference, pixels, direction and what always makes two volumes."""
    groups: dict[Hashable, list[list[Slice]]] = defaultdict(list)
    for each in slices:
        alike = groups[each.series, each.reference, each.rows, each.columns, each.varied, each.is_inverted]
        for group in alike:
            if _is_parallel(group[0], each):
                group.append(each)
                break
        else:
            alike.append([each])
            if sum(len(those) for those in groups.values()) > 10 * IMAGE_STACKS:
                raise TooLarge(MANY)
    return [group for those in groups.values() for group in those]


def _is_parallel(one: Slice, other: Slice) -> bool:
    return all(abs(a - b) < ALIKE for a, b in zip(one.turn, other.turn, strict=True)) and all(
        abs(a - b) < ALIKE * abs(a) for a, b in zip(one.spacing, other.spacing, strict=True)
    )


def _parts(group: Sequence[Slice]) -> tuple[list[list[Slice]], int]:
    """The group as it is where each picture has a place of its own, else split by what tells those of one place.

    The largest part first, and how many pictures were copies.
    """
    single = list({(each.instance, each.frame, each.place): each for each in group}.values())
    if _most_on_one_place(single) == 1:
        return [single], len(group) - len(single)
    best: list[list[Slice]] = []
    for size in range(1, len(APART) + 1):
        for chosen in combinations(APART, size):
            parts: dict[Hashable, list[Slice]] = defaultdict(list)
            for each in single:
                parts[tuple(key(each) for key in chosen)].append(each)
            if all(_most_on_one_place(part) == 1 for part in parts.values()) and (not best or len(parts) < len(best)):
                best = list(parts.values())
    best = best if len(best) <= len(single) / FEWEST else []
    return sorted(best, key=len, reverse=True) or [single], len(group) - len(single)


def _along(slices: Sequence[Slice]) -> Array:
    """(N,) mm along the normal."""
    turn = np.array(slices[0].turn)
    return np.asarray([each.place for each in slices]) @ np.cross(turn[:3], turn[3:])


def _most_on_one_place(slices: Sequence[Slice]) -> int:
    along = np.sort(_along(slices))
    places = np.concatenate([[0], np.cumsum(np.diff(along) > SAME_PLACE)])
    return int(np.bincount(places).max())


def _stacks(slices: Sequence[Slice], copies: int) -> list[Stack]:
    """The volume of these slices; where a wide gap divides them, as between two breasts, and they lie on no common
    grid, one for each part.  BadScan or TooLarge with a sentence."""
    try:
        return [_stack(slices, copies)]
    except BadScan:
        along = _along(slices)
        order = np.argsort(along, kind="stable")
        steps = np.diff(along[order])
        parts = np.split(order, 1 + np.flatnonzero(steps > WIDE * np.median(steps)))
        if len(parts) == 1 or min(map(len, parts)) < FEWEST:
            raise
        return [_stack([slices[at] for at in part], copies) for part in parts]


def _stack(slices: Sequence[Slice], copies: int) -> Stack:
    """The slices in order, with where they lie.  BadScan or TooLarge with a sentence."""
    first = slices[0]
    across, down = np.array(first.turn[:3]), np.array(first.turn[3:])
    sizes = np.array([np.linalg.norm(across), np.linalg.norm(down)])
    if np.abs(sizes - 1.0).max() > ROUNDED or abs(across @ down) > ROUNDED:
        raise BadScan(NO_DIRECTION)
    if _most_on_one_place(slices) > 1:
        raise BadScan(TWICE)
    along = _along(slices)
    order = np.argsort(along, kind="stable")
    slices, steps = tuple(slices[at] for at in order), np.diff(along[order])
    first = slices[0]
    step = float(np.median(steps))
    index = np.concatenate([[0], np.cumsum(np.maximum(1, np.rint(steps / step)))]).astype(np.int64)
    if index[-1] + 1 > len(slices) / (1.0 - MOST_MISSING):
        raise BadScan(UNEVEN)
    places = np.array([each.place for each in slices])
    fit = np.polynomial.polynomial.polyfit(index, places, 1)
    if np.linalg.norm(places - fit[0] - index[:, None] * fit[1], axis=1).max() > FARTHEST_OFF * step:
        raise BadScan(UNEVEN)
    affine = np.eye(4)
    affine[:3, :3] = np.column_stack([first.spacing[1] * across / sizes[0], first.spacing[0] * down / sizes[1], fit[1]])
    affine[:3, 3] = fit[0]
    shape = (first.columns, first.rows, int(index[-1]) + 1)
    _check(affine, shape)
    missing = np.ones(shape[2], np.bool_)
    missing[index] = False
    holes = runs(missing)
    bridged = tuple(start for start, last in holes if start == last)
    gaps = tuple(Gap(2, start, last) for start, last in holes if start < last)
    notes = [f"{copies} DICOM images lay there twice and were read once."] if copies else []
    if bridged:
        which = "A slice is" if len(bridged) == 1 else f"{len(bridged)} single slices are"
        notes.append(f"{which} missing between others; the mean of the neighbours was taken there.")
    normal = np.cross(across, down)
    lean = float(np.degrees(np.arccos(min(1.0, fit[1] @ normal / np.linalg.norm(fit[1]) / np.linalg.norm(normal)))))
    if lean > LEANS:
        notes.append(f"The slices lean by {lean:.0f} degrees against their normal; each is where its header says.")
    return Stack(slices, index, affine, _value(first), "", (*notes, *gaps_said(gaps)), bridged, gaps)


def _check(affine: Array, shape: tuple[int, int, int]) -> None:
    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    if not (sizes.min() >= SMALLEST_VOXEL and sizes.max() <= LARGEST_VOXEL):
        shown = " x ".join(f"{size:.3g}" for size in sizes)
        raise BadScan(f"The voxels of this DICOM series are {shown} mm, which those of no body are; export it again.")
    if abs(np.linalg.det(affine[:3, :3] / sizes)) < FLAT:
        raise BadScan(NO_DIRECTION)
    if np.prod(shape, dtype=np.float64) > IMAGE_VOXELS:
        raise TooLarge(f"This DICOM series has more than the {IMAGE_VOXELS:,} voxels allowed; resample it first.")


def _value(first: Slice) -> str:
    named = "|".join([first.series, first.instance, str(first.frame), *map(str, first.place)])
    return hashlib.sha256(named.encode()).hexdigest()[:DIGITS]
