"""Reads DICOM structure sets (RTSTRUCT): contours in parallel planes, each region filled to a segment.

A plane's contours are filled by turns, so one inside another is a hole.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import STRUCTURES
from breastrig.scan.limits import CONTOUR_BYTES, LABEL_MAP_VOXELS, MEBIBYTE
from breastrig.scan.volumes.answers import TakenAs
from breastrig.scan.volumes.codes import label_of
from breastrig.scan.volumes.slices import between
from breastrig.scan.volumes.volume import Box, Reading, Segment, Volume, check_affine, check_shape, frame_digest

CONTOUR_DATA = 0x30060050
FINEST = 0.5  # mm of a voxel within the planes
FARTHEST = 1e5  # mm from the origin
FLAT = 0.2  # mm by which a contour's points may leave their plane
SAME_PLANE = 0.05  # mm
FARTHEST_OFF = 0.3  # of the distance between planes that one may lie off its place
LESION = ("GTV",)  # interpreted types
TISSUE = ("EXTERNAL", "ORGAN", "AVOIDANCE", "PTV", "CTV", "TREATED_VOLUME", "IRRAD_VOLUME", "BOLUS", "SUPPORT")
NO_CONTOURS = "This structure set (RTSTRUCT) holds no closed contours; export it again."
ONE_PLANE = "The contours of this structure set (RTSTRUCT) lie in one plane alone; draw them in all slices."
NOT_PARALLEL = (
    "The contours of this structure set (RTSTRUCT) do not lie in parallel planes at equal distances; "
    "export them as a DICOM segmentation (SEG)."
)


@dataclass
class _Region:
    """The contours of one ROI."""

    number: int
    label: str
    coded: TakenAs | None
    contours: list[tuple[float, Array]] = field(default_factory=list)  # each with its place along the normal, (N, 2) mm


def is_structures(dataset: Any) -> bool:
    return str(dataset.get("SOPClassUID", "")) == STRUCTURES or str(dataset.get("Modality", "")) == "RTSTRUCT"


def structures_volume(dataset: Any) -> Volume:
    """The volume of a parsed file.  Raises BadScan or TooLarge with a sentence."""
    loops = {
        number: list(_loops(each)) for number, each in _listed(dataset, "ROIContourSequence", "ReferencedROINumber")
    }
    axes = _axes([loop for each in loops.values() for loop in each])
    regions = _regions(dataset, loops, axes)
    first, step = _planes(regions)
    low = np.min([loop.min(axis=0) for each in regions for _, loop in each.contours], axis=0)
    high = np.max([loop.max(axis=0) for each in regions for _, loop in each.contours], axis=0)
    count = max(round((at - first) / step) for each in regions for at, _ in each.contours) + 1
    check_shape((2, 2, max(2, count)))
    size = FINEST
    while np.prod(shape := np.ceil((high - low) / size) + 3.0) * max(2, count) > LABEL_MAP_VOXELS:
        size *= 2.0
    low = low - size
    grid = (int(shape[0]), int(shape[1]), max(2, count))
    check_shape(grid)
    affine = np.eye(4)
    affine[:3, :3] = axes * [size, size, step]
    affine[:3, 3] = axes @ [*low, first]
    check_affine(affine)
    segments, notes = [], list[str]()
    for each in regions:
        planes = defaultdict[int, list[Array]](list)
        for at, loop in each.contours:
            planes[round((at - first) / step)].append((loop - low) / size)
        bridged = [at + 1 for at in planes if at + 1 not in planes and at + 2 in planes]
        segments.append(_segment(each, dict(planes), bridged))
        if bridged:
            which = "a plane" if len(bridged) == 1 else f"{len(bridged)} single planes"
            notes.append(
                f"Region {each.number} has no contour in {which} between others; the neighbours were joined there."
            )
    reference: Any = next(iter(dataset.get("ReferencedFrameOfReferenceSequence", None) or []), {})
    uid = str(reference.get("FrameOfReferenceUID", ""))
    return Volume(grid, tuple(segments), (Reading("", "", affine),), notes=tuple(notes), frame=frame_digest(uid))


def _listed(dataset: Any, name: str, key: str) -> Iterator[tuple[int, Any]]:
    for each in dataset.get(name, None) or []:
        if each.get(key, None) is not None:
            yield int(each[key].value), each


def _loops(region: Any) -> Iterator[Array]:
    """(N, 3) mm of each closed contour."""
    for contour in region.get("ContourSequence", None) or []:
        if str(contour.get("ContourGeometricType", "")) not in ("CLOSED_PLANAR", "CLOSEDPLANAR_XOR"):
            continue
        raw = contour.get_item(CONTOUR_DATA)
        value = b"" if raw is None or raw.value is None else raw.value
        text = value if isinstance(value, bytes) else b"\\".join(str(each).encode() for each in value)
        numbers = np.array([float(each) for each in text.split(b"\\") if each.strip(b" \0")], np.float64)
        if len(numbers) >= 9 and len(numbers) % 3 == 0 and np.abs(numbers).max() < FARTHEST:
            yield numbers.reshape(-1, 3)


def _axes(loops: list[Array]) -> Array:
    """(3, 3) columns: two directions within the planes, and their normal."""
    if not loops:
        raise BadScan(NO_CONTOURS)
    if sum(loop.nbytes for loop in loops) > CONTOUR_BYTES:
        raise TooLarge(f"This structure set has more than {CONTOUR_BYTES // MEBIBYTE} MB of contours; export fewer.")
    widest = max(loops, key=lambda loop: float(np.ptp(loop, axis=0).max()))
    _, _, turned = np.linalg.svd(widest - widest.mean(axis=0), full_matrices=False)
    normal = turned[2]
    along = int(np.abs(normal).argmax())
    if abs(normal[along]) > 1.0 - 1e-6:  # as nearly all are; then exactly
        normal = np.eye(3)[along]
    normal = normal if normal[along] > 0.0 else -normal
    start = np.eye(3)[(along + 1) % 3]
    across = start - (start @ normal) * normal
    across /= np.linalg.norm(across)
    return np.column_stack([across, np.cross(normal, across), normal])


def _regions(dataset: Any, loops: Mapping[int, list[Array]], axes: Array) -> list[_Region]:
    names = dict(_listed(dataset, "StructureSetROISequence", "ROINumber"))
    observed = dict(_listed(dataset, "RTROIObservationsSequence", "ReferencedROINumber"))
    found = []
    for number, each in loops.items():
        said: Any = names.get(number, {})
        seen: Any = observed.get(number, {})
        words = (str(said.get("ROIName", "") or ""), str(seen.get("ROIObservationLabel", "") or ""))
        kind = str(seen.get("RTROIInterpretedType", "") or "").strip().upper()
        coded: TakenAs | None = "lesion" if kind in LESION else "tissue" if kind in TISSUE else None
        region = _Region(number, label_of(words), coded)
        for loop in each:
            placed = loop @ axes
            if np.ptp(placed[:, 2]) > FLAT:
                raise BadScan(NOT_PARALLEL)
            region.contours.append((float(placed[:, 2].mean()), placed[:, :2]))
        if region.contours:
            found.append(region)
    return found


def _planes(regions: list[_Region]) -> tuple[float, float]:
    """Where the first plane lies along the normal, and the distance between planes."""
    places = np.sort([at for each in regions for at, _ in each.contours])
    apart = [np.diff(np.sort([at for at, _ in each.contours])) for each in regions]
    steps = np.concatenate(apart)
    steps = steps[steps > SAME_PLANE]
    if not len(steps):
        raise BadScan(ONE_PLANE)
    step = float(np.median(steps[steps < 1.5 * steps.min()]))
    index = np.rint((places - places[0]) / step)
    first, step = (float(each) for each in np.polynomial.polynomial.polyfit(index, places, 1))
    if np.abs(places - first - step * index).max() > FARTHEST_OFF * step:
        raise BadScan(NOT_PARALLEL)
    return first, step


def _segment(region: _Region, planes: Mapping[int, list[Array]], bridged: list[int]) -> Segment:
    corners = np.concatenate([loop for loops in planes.values() for loop in loops])
    low, high = np.floor(corners.min(axis=0)).astype(int), np.ceil(corners.max(axis=0)).astype(int) + 1
    box = (slice(low[0], high[0]), slice(low[1], high[1]), slice(min(planes), max(planes) + 1))
    count = sum(_area(loop) for loops in planes.values() for loop in loops) * (1.0 + len(bridged) / len(planes))
    inside = partial(_inside, planes, bridged, box)
    return Segment(region.number, box, max(1, round(count)), inside, region.label, region.coded)


def _area(loop: Array) -> float:
    """In voxels."""
    x, y = loop.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


def _inside(planes: Mapping[int, list[Array]], bridged: list[int], box: Box) -> Booleans:
    """(of the box's shape) the region's voxels."""
    from skimage.draw import polygon  # slow to load, and few scans are contours

    across, down, along = box
    shape = (across.stop - across.start, down.stop - down.start)
    found = np.zeros((*shape, along.stop - along.start), np.bool_)
    for at, loops in planes.items():
        plane: NDArray[np.bool_] = found[:, :, at - along.start]
        for loop in loops:
            rows, columns = polygon(loop[:, 0] - across.start, loop[:, 1] - down.start, shape)
            plane[rows, columns] ^= True
    for at in bridged:
        here = at - along.start
        found[:, :, here] = between(found[:, :, here - 1], found[:, :, here + 1])
    return found
