"""Numbers on one grid of voxels as a file has them, which are labels or an image, and the segments of labels."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans
from breastrig.scan.limits import LABELS
from breastrig.scan.volumes.answers import TakenAs
from breastrig.scan.volumes.grids.frames import Frames
from breastrig.scan.volumes.slices import bridged_labels, gaps_said
from breastrig.scan.volumes.volume import Gap, Segment, Volume

WHOLE = 0.02  # farthest from a whole number that a label is stored as
FARTHEST = 0.4  # the same of labels that were scaled to 255 or 65,535 levels, half a level at most
FEW = 20  # labels; of more it is asked whether they are areas
AREAS = 0.5  # share of neighbours within the body that have the same label; 0.9 in label maps, 0.1 in images
LARGEST_LABEL = 65_535
SLAB = 2**22  # voxels looked at together
EMPTY = "{} between others was filled from the neighbours."
NO_NUMBER = "Voxels without a number (NaN) were taken for air."


@dataclass(frozen=True)
class Described:
    """A file's own words on one label."""

    number: int  # of the segment
    label: str = field(default="", repr=False)
    coded: TakenAs | None = None


@dataclass(frozen=True, eq=False)
class Grid:
    """A file's numbers, not yet looked at."""

    layers: tuple[NDArray[Any], ...]  # (I, J, K) each, as stored; several where segments overlap
    frames: Frames
    slope: float = 1.0  # of the numbers that are meant
    intercept: float = 0.0
    slice_axis: int = 2
    described: Mapping[tuple[int, int], Described] = field(default_factory=dict)  # by layer and label


def widest_axis(steps: Array) -> int:
    """The axis along which slices lie where a file names none: that of the largest step, of equal ones the last."""
    return 2 - int(np.argmax(np.asarray(steps)[2::-1]))


def volume_of(grid: Grid) -> Volume | None:
    """The segments, where the numbers are labels; None where they are an image."""
    readings, doubt, notes = grid.frames
    segments, gaps, count, any_nan = list[Segment](), list[Gap](), 0, False
    free = max((each.number for each in grid.described.values()), default=0)
    for at, raw in enumerate(grid.layers):
        found = _labels(raw, grid.slope, grid.intercept)
        if found is None or not _are_areas(found[0], len(found[1])):
            return None
        labels, values, has_nan = found
        filled, open_ = bridged_labels(labels, grid.slice_axis)
        count, any_nan, gaps = count + filled, any_nan or has_nan, [*gaps, *open_]
        boxes = ndimage.find_objects(labels, max_label=len(values) - 1)
        counts = np.bincount(labels.ravel(order="K"), minlength=len(values))
        for code, (value, box) in enumerate(zip(values[1:], boxes, strict=True), 1):
            if box is None:
                continue
            said = grid.described.get((at, value))
            if said is None:  # of a file that describes others
                said = Described(free + value if grid.described else value)
            inside = partial(_inside, labels, box, code)
            whole = (box[0], box[1], box[2])
            segments.append(Segment(said.number, whole, int(counts[code]), inside, said.label, said.coded))
    notes += (NO_NUMBER,) if any_nan else ()
    notes += (EMPTY.format("An empty slice" if count == 1 else f"{count} empty slices"),) if count else ()
    notes += gaps_said(tuple(gaps))
    ordered = tuple(sorted(segments, key=lambda each: each.number))
    return Volume(grid.layers[0].shape, ordered, readings, doubt, notes, tuple(gaps))


def _inside(labels: NDArray[np.uint8], box: tuple[slice, ...], code: int) -> Booleans:
    return np.asarray(labels[box] == code)


def _labels(raw: NDArray[Any], slope: float, intercept: float) -> tuple[NDArray[np.uint8], list[int], bool] | None:
    """(I, J, K) codes, the label of each code, the first of them 0, and whether there was NaN; None for an image."""
    near = float(np.clip(0.51 * abs(slope), WHOLE, FARTHEST)) if raw.dtype.kind in "iu" else WHOLE
    is_whole = raw.dtype.kind in "iu" and slope == 1.0 and intercept == 0.0
    codes = np.zeros(raw.shape, np.uint8, order="F")
    values, has_nan = [0], False
    step = max(1, SLAB // (raw.shape[0] * raw.shape[1]))
    for start in range(0, raw.shape[2], step):
        slab = raw[:, :, start : start + step]
        if not is_whole:
            numbers = slab.astype(np.float64) * slope + intercept
            missing = np.isnan(numbers)
            if missing.any():
                has_nan, numbers[missing] = True, 0.0
            slab = np.rint(numbers)
            if not np.abs(numbers - slab).max() <= near:  # true for what is infinite, too
                return None
        here = np.unique(slab)
        if len(here) > LABELS or max(-float(here[0]), float(here[-1])) > LARGEST_LABEL:
            return None
        values += [int(value) for value in here if int(value) not in values]
        if len(values) > LABELS:
            return None
        order = np.argsort(values)
        codes[:, :, start : start + step] = order[np.searchsorted(np.asarray(values)[order], slab)]
    return codes, values, has_nan


def _are_areas(labels: NDArray[np.uint8], count: int) -> bool:
    """False for an image of no more grey values than a label map may have."""
    one, other = labels[1:], labels[:-1]
    both = (one > 0) & (other > 0)
    return count <= FEW or bool(np.count_nonzero(both & (one == other)) >= AREAS * np.count_nonzero(both))
