"""Reads DICOM segmentations (SEG); their frames need position, orientation and spacing, nothing else.

Each segment has frames of its own, so segments may overlap, and each is read from its own frames.
"""

import io
import zlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import DICOM_MARK, DICOM_MARK_AT, SEGMENTATIONS, STRUCTURES
from breastrig.scan.limits import (
    DICOM_BYTES,
    DICOM_ELEMENTS,
    DICOM_FRAMES,
    DICOM_ITEMS,
    LABEL_MAP_VOXELS,
    MEBIBYTE,
)
from breastrig.scan.volumes.answers import TakenAs
from breastrig.scan.volumes.codes import coded_as, label_of
from breastrig.scan.volumes.slices import between, gaps_said, runs
from breastrig.scan.volumes.volume import (
    NOT_GREY,
    Gap,
    Reading,
    Segment,
    Volume,
    check_affine,
    check_shape,
    frame_digest,
)

DEFLATED, PLAIN = b"1.2.840.10008.1.2.1.99", b"1.2.840.10008.1.2.1\0\0\0"  # transfer syntaxes
GROUP_LENGTH = b"\x02\x00\x00\x00UL\x04\x00"  # the element with which the header of a file begins
ITEM = b"\xfe\xff\x00\xe0"
EXPORT = "export the structures as a DICOM segmentation (SEG) or as a NIfTI label map"
OTHER_CLASSES = {
    STRUCTURES: f"This is a structure set (RTSTRUCT), which shows no skin; give it with its image, or {EXPORT}.",
    "1.2.840.10008.5.1.4.1.1.66.5": f"This is a DICOM surface segmentation, which is not read; {EXPORT}.",
    "1.2.840.10008.1.3.10": "This is the list of a DICOM medium (DICOMDIR); give its folder, or a segmentation's file.",
}
AN_IMAGE = "This is an image, not a segmentation of lesions; give the segmentation."
NO_PLACE = "This DICOM segmentation does not say where its frames lie; export it again."
DAMAGED = "This DICOM file is damaged or cut off and cannot be read; export it again."
COMPRESSED = "The pixels of this DICOM file are compressed in a way that is not read; export it uncompressed."
ALIKE = 1e-3  # of direction cosines, and of pixel sizes in their own size
FARTHEST_OFF = 0.3  # of the distance between slices that one may lie off its place; writers round, and patients breathe
SAME_SLICE = 0.3  # of the distance between slices, below which frames lie on one
NO_STEP = 0.1  # of the largest distance between neighbours: less is no distance between slices
NEARLY = 0.1  # of the named distance between slices: how far a multiple of it may be off


@dataclass(frozen=True, eq=False)
class _Frames:
    """The pixels of all frames."""

    pixel: Callable[[int], NDArray[Any]]  # (R, C) of a frame
    places: Array  # (N, 3) mm, LPS, of each frame's first pixel
    across: Array  # (3,) mm, from pixel to pixel along a row
    down: Array  # (3,) mm, along a column
    segments: list[int | None]  # of each frame; None where its pixels are the segments' numbers
    named_step: float | None  # mm between slices, as the file says
    thickness: float | None  # mm of a slice, as the file says


@dataclass
class _Held:
    """The voxels of a segment: its frames and bounds."""

    frames: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))  # slice -> frames that show it
    empty: set[int] = field(default_factory=set)  # slices that are known to hold nothing of it
    low: Integers = field(default_factory=lambda: np.full(2, 2**31))  # first column and row
    high: Integers = field(default_factory=lambda: np.zeros(2, np.int64))  # behind the last
    count: int = 0  # pixels

    def bridged(self) -> list[int]:
        """Single slices between others for which it has no frame."""
        return [
            at + 1
            for at in self.frames
            if at + 2 in self.frames and at + 1 not in self.frames and at + 1 not in self.empty
        ]


def segmentation_volume(dataset: Any) -> Volume:
    """The volume of a parsed file.  Raises BadScan or TooLarge with a sentence."""
    _check_class(dataset)
    frames = _frames(dataset)
    slices, step, missing = _slices(frames)
    shape = (int(dataset.Columns), int(dataset.Rows), max(2, int(slices.max()) + 1))
    check_shape(shape)
    affine = np.eye(4)
    affine[:3, :3] = np.column_stack([frames.across, frames.down, step])
    affine[:3, 3] = np.median(frames.places - slices[:, None] * step, axis=0)
    check_affine(affine)
    described = _descriptions(dataset)
    held = _held(frames, slices)
    segments, notes = [], list[str]()
    for number, where in sorted(held.items()):
        first, last = min(where.frames), max(where.frames)
        box = (slice(where.low[0], where.high[0]), slice(where.low[1], where.high[1]), slice(first, last + 1))
        label, coded = _described(described.get(number))
        segments.append(Segment(number, box, where.count, partial(_inside, frames, where, number, box), label, coded))
        if bridged := where.bridged():
            which = "a slice" if len(bridged) == 1 else f"{len(bridged)} single slices"
            notes.append(f"Segment {number} has no frame in {which} between others; the neighbours were joined there.")
    if not segments:
        raise BadScan("This DICOM segmentation holds no segment; export it again.")
    notes += _perhaps_coarser(frames, float(np.linalg.norm(step)))
    gaps = tuple(Gap(2, first, last) for first, last in runs(missing) if last > first)
    return Volume(
        shape,
        tuple(segments),
        (Reading("", "", affine),),
        notes=(*notes, *gaps_said(gaps)),
        gaps=gaps,
        frame=frame_digest(str(dataset.get("FrameOfReferenceUID", ""))),
    )


def _descriptions(dataset: Any) -> dict[int, Any]:
    """The segments' descriptions by segment number."""
    listed = dataset.get("SegmentSequence", None) or []
    return {int(each.SegmentNumber): each for each in listed if "SegmentNumber" in each}


def dataset_of(data: bytes) -> Any:
    """The whole file, parsed, after its limits are checked."""
    from pydicom.filereader import read_partial

    data = plain_dicom(data)
    if data.count(ITEM) > DICOM_ITEMS:
        raise TooLarge(f"This DICOM file has more than the {DICOM_ITEMS:,} entries allowed; export fewer frames.")
    seen = 0

    def stop(*_: Any) -> bool:
        nonlocal seen
        seen += 1
        if seen > DICOM_ELEMENTS:
            raise TooLarge(f"This DICOM file has more than the {DICOM_ELEMENTS:,} elements allowed; export it again.")
        return False

    return read_partial(io.BytesIO(data), stop, force=True)


def plain_dicom(data: bytes) -> bytes:
    """The file with the preamble that belongs before it, its content not deflated.  Raises BadScan or TooLarge."""
    if data.startswith(DICOM_MARK):
        data = bytes(DICOM_MARK_AT) + data
    return _inflated(data) if DEFLATED in data else data


def _inflated(data: bytes) -> bytes:
    """The file with its deflated content unpacked. Raises BadScan or TooLarge."""
    start = DICOM_MARK_AT + 4 if data[DICOM_MARK_AT : DICOM_MARK_AT + 4] == DICOM_MARK else 0
    if not data.startswith(GROUP_LENGTH, start):
        raise BadScan(DAMAGED)
    length = int.from_bytes(data[start + 8 : start + 12], "little")
    header, packed = data[: start + 12 + length], data[start + 12 + length :]
    if DEFLATED not in header:  # it names that packing elsewhere
        return data
    whole = zlib.decompressobj(wbits=-zlib.MAX_WBITS).decompress(packed, DICOM_BYTES + 1)
    if len(whole) > DICOM_BYTES:
        raise TooLarge(f"This DICOM file unpacks to more than the {DICOM_BYTES // MEBIBYTE} MB allowed.")
    return header.replace(DEFLATED, PLAIN) + whole


def _check_class(dataset: Any) -> None:
    if (other := OTHER_CLASSES.get(str(dataset.get("SOPClassUID", "")))) is not None:
        raise BadScan(other)
    if dataset.get("SOPClassUID", "") in SEGMENTATIONS or dataset.get("Modality", "") == "SEG":
        return
    if dataset.get("Modality", "") == "RTSTRUCT":
        raise BadScan(OTHER_CLASSES[STRUCTURES])
    if "ImagePositionPatient" in dataset:
        raise BadScan(AN_IMAGE)
    raise BadScan(f"This DICOM file holds neither an image nor a segmentation; {EXPORT}.")


def _frames(dataset: Any) -> _Frames:
    own = list(dataset.get("PerFrameFunctionalGroupsSequence", None) or [])
    count, rows, columns = int(dataset.get("NumberOfFrames", None) or len(own)), int(dataset.Rows), int(dataset.Columns)
    if int(dataset.get("SamplesPerPixel", 1)) != 1:
        raise BadScan(NOT_GREY)
    if count > DICOM_FRAMES or count * rows * columns > 16 * LABEL_MAP_VOXELS or rows * columns > LABEL_MAP_VOXELS:
        pixels = f"{count:,} frames of {rows} x {columns} pixels"
        raise TooLarge(f"This DICOM segmentation has {pixels}, more than is read; crop it.")
    shared: Any = next(iter(dataset.get("SharedFunctionalGroupsSequence", None) or []), {})
    if count < 1 or rows < 1 or columns < 1 or len(own) < count:
        raise BadScan(NO_PLACE if rows > 0 and columns > 0 and count > 0 else DAMAGED)

    def said(frame: int, group: str, name: str, size: int) -> NDArray[np.float64] | None:
        for groups in (own[frame], shared):
            item: Any = next(iter(groups.get(group, None) or []), {})
            if (value := item.get(name, None)) is not None:
                return _numbers(value, size)
        value = dataset.get(name, None)
        return None if value is None else _numbers(value, size)

    places, turns, sizes, segments = [], [], [], list[int | None]()
    kind = str(dataset.get("SegmentationType", ""))
    known = list(_descriptions(dataset))
    only = known[0] if len(known) == 1 else None
    for frame in range(count):
        place = said(frame, "PlanePositionSequence", "ImagePositionPatient", 3)
        turn = said(frame, "PlaneOrientationSequence", "ImageOrientationPatient", 6)
        size = said(frame, "PixelMeasuresSequence", "PixelSpacing", 2)
        if place is None or turn is None or size is None:
            raise BadScan(NO_PLACE)
        places.append(place)
        turns.append(turn)
        sizes.append(size)
        number = said(frame, "SegmentIdentificationSequence", "ReferencedSegmentNumber", 1)
        segments.append(None if kind == "LABELMAP" else only if number is None else int(number[0]))
    turn, size = np.asarray(turns[0]), np.asarray(sizes[0])
    if not (np.allclose(turns, turn, atol=ALIKE) and np.allclose(sizes, size, rtol=ALIKE)):
        raise BadScan("The frames of this DICOM segmentation do not lie in parallel on one grid; resample it first.")
    across, down = turn[:3] / np.linalg.norm(turn[:3]), turn[3:] / np.linalg.norm(turn[3:])
    if not np.isfinite([*across, *down]).all() or abs(across @ down) > 0.01:
        raise BadScan(NO_PLACE)
    if kind != "LABELMAP" and None in segments:
        if kind in ("BINARY", "FRACTIONAL") or int(dataset.get("BitsAllocated", 8)) == 1:
            raise BadScan("This DICOM segmentation does not say to which segments its frames belong; export it again.")
        segments = [None] * count
    named = said(0, "PixelMeasuresSequence", "SpacingBetweenSlices", 1)
    thick = said(0, "PixelMeasuresSequence", "SliceThickness", 1)
    step, thickness = (None if each is None or each[0] <= 0.0 else float(each[0]) for each in (named, thick))
    pixel = _pixels(dataset, count, rows, columns)
    return _Frames(pixel, np.asarray(places), size[1] * across, size[0] * down, segments, step, thickness)


def _numbers(value: Any, size: int) -> NDArray[np.float64]:
    found = np.asarray(value, np.float64).reshape(-1)
    if found.shape != (size,) or not np.isfinite(found).all():
        raise BadScan(NO_PLACE)
    return found


def _pixels(dataset: Any, count: int, rows: int, columns: int) -> Callable[[int], NDArray[Any]]:
    """A function frame -> (R, C) pixels: booleans, or segment numbers."""
    bits = int(dataset.get("BitsAllocated", 1))
    if bits not in (1, 8, 16):
        raise BadScan(NOT_GREY)
    syntax = getattr(dataset, "file_meta", {}).get("TransferSyntaxUID", None)
    is_share = dataset.get("SegmentationType", "") == "FRACTIONAL"
    half = 0.5 * float(dataset.get("MaximumFractionalValue", 255) or 255) if is_share else None
    if syntax is not None and syntax.is_compressed and not syntax.is_deflated:
        stored = _decoder(dataset)
    else:
        content = dataset.get("PixelData", None)
        size = rows * columns
        if content is None or len(content) * 8 < count * size * bits:
            raise BadScan(DAMAGED)
        if bits == 1:
            packed = np.frombuffer(content, np.uint8)
            stored = partial(_bits, packed, size, (rows, columns))
        else:
            order = "<" if dataset.original_encoding[1] is not False else ">"
            whole = np.frombuffer(content, np.dtype(f"{order}u{bits // 8}"), count * size)
            stored = whole.reshape(count, rows, columns).__getitem__

    def pixel(frame: int) -> NDArray[Any]:
        found = stored(frame)
        return found if half is None else np.asarray(found > half)

    return pixel


def _bits(packed: NDArray[np.uint8], size: int, shape: tuple[int, int], frame: int) -> NDArray[np.uint8]:
    """Frames follow one another without a pad, eight pixels a byte."""
    first, stop = frame * size, (frame + 1) * size
    bits = np.unpackbits(packed[first // 8 : -(-stop // 8)], bitorder="little")
    return bits[first % 8 : first % 8 + size].reshape(shape)


def _decoder(dataset: Any) -> Callable[[int], NDArray[Any]]:
    from pydicom.pixels.utils import iter_pixels

    defaults = {"PhotometricInterpretation": "MONOCHROME2", "SamplesPerPixel": 1, "PixelRepresentation": 0}
    for name, value in defaults.items():
        dataset.setdefault(name, value)
    dataset.setdefault("BitsStored", dataset.get("BitsAllocated", 8))

    def stored(frame: int) -> NDArray[Any]:
        try:
            return np.asarray(next(iter(iter_pixels(dataset, indices=[frame], raw=True))))
        except Exception as error:  # no decoder for it, or damaged
            raise BadScan(COMPRESSED) from error

    return stored


def _slices(frames: _Frames) -> tuple[Integers, Array, Booleans]:
    """(N,) the slice of each frame, (3,) mm from slice to slice, and (S,) which slices have no frame at all."""
    normal = np.cross(frames.across, frames.down)
    normal /= np.linalg.norm(normal)
    along = frames.places @ normal
    order = np.argsort(along, kind="stable")
    steps = np.diff(along[order])
    if np.ptp(along) <= 0.0:  # one slice, as a small lesion may have
        only = frames.named_step or frames.thickness
        if only is None:
            raise BadScan("This file is a single slice; export the whole volume.")
        return np.zeros(len(along), np.int64), only * normal, np.zeros(1, np.bool_)
    named, step = frames.named_step, float(np.median(steps[steps > NO_STEP * steps.max()]))
    apart = steps > SAME_SLICE * min(step, named or step)
    step = float(np.median(steps[apart]))
    if named is not None and named < step and abs(step / named - round(step / named)) < NEARLY:
        step = named
    index = np.zeros(len(along), np.int64)
    index[order] = np.concatenate([[0], np.cumsum(np.where(apart, np.maximum(1, np.rint(steps / step)), 0.0))])
    fit = np.polynomial.polynomial.polyfit(index, frames.places, 1)
    off = np.linalg.norm(frames.places - fit[0] - index[:, None] * fit[1], axis=1)
    if off.max() > FARTHEST_OFF * float(fit[1] @ normal):
        raise BadScan("The slices of this DICOM segmentation are unevenly spaced; resample it first.")
    missing = np.ones(int(index.max()) + 1, np.bool_)
    missing[index] = False
    return index, fit[1], missing


def _perhaps_coarser(frames: _Frames, step: float) -> list[str]:
    """A sentence where frames lie `step` mm apart, a multiple of the slices' thickness, and no spacing is named.

    Slices may be thinner than their distance, so nothing is bridged.
    """
    if frames.named_step is not None or frames.thickness is None:
        return []
    times = step / frames.thickness
    if round(times) < 2 or abs(times - round(times)) > NEARLY:
        return []
    return [
        f"Frames lie {step:.3g} mm apart, {round(times)} times the slices' thickness, and the file does not name the "
        "distance between slices: frames may be missing. Look at the skin, or export the segmentation with all frames."
    ]


def _held(frames: _Frames, slices: Integers) -> dict[int, _Held]:
    """Each segment that has any pixel, by its number."""
    held: dict[int, _Held] = defaultdict(_Held)
    for frame, at in enumerate(slices.tolist()):
        pixels, number = frames.pixel(frame), frames.segments[frame]
        shown = [number] if number is not None else [int(each) for each in np.unique(pixels) if each]
        for each in shown:
            inside = pixels != 0 if number is not None else pixels == each
            rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
            if not len(rows):
                held[each].empty.add(at)
                continue
            where = held[each]
            where.frames[at].append(frame)
            where.low = np.minimum(where.low, [columns[0], rows[0]])
            where.high = np.maximum(where.high, [columns[-1] + 1, rows[-1] + 1])
            where.count += int(np.count_nonzero(inside))
    if None in frames.segments:  # each frame shows all segments that there are
        for where in held.values():
            where.empty |= set(slices.tolist()) - where.frames.keys()
    return {number: where for number, where in held.items() if where.frames and number}


def _inside(frames: _Frames, where: _Held, number: int, box: tuple[slice, slice, slice]) -> Booleans:
    """(of the box's shape) the segment's voxels."""
    columns, rows, along = box
    found = np.zeros((columns.stop - columns.start, rows.stop - rows.start, along.stop - along.start), np.bool_)
    for at, those in where.frames.items():
        for frame in those:
            pixels = frames.pixel(frame)[rows, columns].T
            found[:, :, at - along.start] |= pixels == number if frames.segments[frame] is None else pixels != 0
    for at in where.bridged():
        here = at - along.start
        found[:, :, here] = between(found[:, :, here - 1], found[:, :, here + 1])
    return found


def _described(segment: Any) -> tuple[str, TakenAs | None]:
    """The file's words for it, and what its codes say."""
    if segment is None:
        return "", None
    kinds, categories = (
        [(str(each.get("CodeValue", "")), str(each.get("CodeMeaning", ""))) for each in segment.get(name, None) or []]
        for name in ("SegmentedPropertyTypeCodeSequence", "SegmentedPropertyCategoryCodeSequence")
    )
    words = (str(segment.get("SegmentLabel", "") or ""), *(meaning for _, meaning in kinds))
    return label_of(words), coded_as({code for code, _ in categories}, {code for code, _ in kinds})
