"""The skin and the lesions of a label map: NIfTI, or DICOM segmentation (SEG); with the extra `mri`.

A label map says for each voxel what is there, 0 for nothing.  The body is all that the air in front of it does not
reach, so labels may leave parts of it out (lungs, fat); where the field of view ends the skin ends, open.  Places are
in the DICOM patient frame (LPS: to her left, her back, her head), in mm, as mesh files of 3D Slicer have them.
"""

import importlib.util
import io
import re
import warnings
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import LABEL_MAP_BYTES, LABEL_MAP_VOXELS, LABELS, MEBIBYTE
from breastrig.scan.piece import BallInside, Piece, Pieces

CELL = 1.5  # mm; finer voxels are averaged, for no skin of an MRI is known better
SLIVER = 1e-6  # mm^2 of twice the area; marching cubes leaves some
SMOOTHING = 1.2  # mm, of the Gaussian over the steps between voxels
LARGEST_LESION = 40.0  # mm radius of a label without a name; what is larger is tissue
LARGEST_NAMED = 80.0  # mm radius, as a plan takes it
NAME = 60  # characters of a segment's
SMALLEST_LESION = 1.0  # mm radius; less is noise
LESIONS = 20
COMPACT = 0.4  # share of the ellipsoid in its bounding box that a lesion fills; vessels and glands fill less
NAMED_LESION = re.compile(r"lesion|tumou?r|mass|neoplasm|cancer|carcinoma|malignan|cyst|fibroadenoma", re.IGNORECASE)
RAS_TO_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
FRAME = "Places are in the DICOM patient frame (LPS), mm; the skin was made from the label map."
NEEDS = 'Label maps need "breastrig[mri]"; install it, or export the skin as PLY, STL or OBJ.'
IMAGE = "This is an image, not a label map; segment body and lesions first (0 is air), and give that."


@dataclass(frozen=True, eq=False)
class LabelMap:
    labels: NDArray[Any]  # (I, J, K) whole numbers, 0: nothing
    affine: Array  # (4, 4) voxel indices to mm, LPS
    names: dict[int, str]  # of labels, where the file has them


def label_map_pieces(data: bytes, kind: str) -> Pieces:
    """The skin with `lesions`; `kind` is nifti or dicom.  Raises BadScan or TooLarge with a sentence."""
    if importlib.util.find_spec("nibabel" if kind == "nifti" else "highdicom") is None:
        raise BadScan(NEEDS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about headers that are not quite as their standard wants them
        found = _nifti(data) if kind == "nifti" else _dicom(data)
    lesions = tuple(_lesions(found))
    body = _body(found)
    vertices, faces = _surface(body, found.affine)
    said = [f"{each.name} was found in the label map, {2 * each.radius:.0f} mm across." for each in lesions]
    return Pieces((Piece(vertices, faces),), notes=(FRAME, *said), unit="mm", is_label_map=True, lesions=lesions)


def gunzipped(data: bytes) -> bytes:
    """The file in a .gz; TooLarge beyond the limit of label maps, BadScan where it is damaged."""
    unpacker = zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)
    try:
        whole = unpacker.decompress(data, LABEL_MAP_BYTES + 1)
    except zlib.error as error:
        raise BadScan("This .gz file is damaged; pack it again.") from error
    if len(whole) > LABEL_MAP_BYTES:
        raise TooLarge(f"This .gz file unpacks to more than the {LABEL_MAP_BYTES // MEBIBYTE} MB allowed.")
    if not unpacker.eof:
        raise BadScan("This .gz file is cut off; pack it again.")
    return whole


def _nifti(data: bytes) -> LabelMap:
    import nibabel

    image: Any = (nibabel.Nifti2Image if data[4:8] == b"n+2\0" else nibabel.Nifti1Image).from_bytes(data)
    _check_size(image.shape)
    values = np.asanyarray(image.dataobj)
    while values.ndim > 3 and values.shape[-1] == 1:
        values = values[..., 0]
    mm = {"meter": 1e3, "micron": 1e-3}.get(image.header.get_xyzt_units()[0], 1.0)
    affine = np.diag([mm, mm, mm, 1.0]) @ RAS_TO_LPS @ image.affine
    return LabelMap(_whole_numbers(values), affine, {})


def _dicom(data: bytes) -> LabelMap:
    import highdicom
    from pydicom import dcmread

    headers = dcmread(io.BytesIO(data), stop_before_pixels=True)
    if headers.get("Modality") != "SEG":
        raise BadScan(IMAGE)
    segments = highdicom.seg.Segmentation.from_dataset(dcmread(io.BytesIO(data)), copy=False)
    numbers = [int(number) for number in segments.segment_numbers]
    frames = int(headers.get("NumberOfFrames", 1))
    _check_size((int(headers.Rows), int(headers.Columns), frames))
    described = {number: segments.get_segment_description(number) for number in numbers}
    names = {
        number: _title(f"{each.segment_label or ''} {each.segmented_property_type.meaning}", number)
        for number, each in described.items()
    }
    labels: NDArray[Any] | None = None
    for number in numbers:  # one after the other: they may overlap, and a lesion lies in tissue
        volume = segments.get_volume(segment_numbers=[number], rescale_fractional=True)
        inside = np.asarray(volume.array).reshape(volume.array.shape[:3]) > 0.5
        if labels is None:
            labels = np.zeros(inside.shape, np.uint16)
            affine = np.asarray(volume.affine, np.float64)
        labels[inside & ((labels == 0) | bool(NAMED_LESION.search(names[number])))] = number
    if labels is None:
        raise BadScan("This DICOM segmentation holds no segment; export it again.")
    return LabelMap(labels, affine, names)


def _title(text: str, number: int) -> str:
    """What can be shown of a name."""
    shown = " ".join("".join(each if each.isprintable() else " " for each in text).split())
    return shown[:NAME].strip() or f"Segment {number}"


def _check_size(shape: tuple[int, ...]) -> None:
    if len(shape) < 3 or any(size > 1 for size in shape[3:]):
        raise BadScan("This label map must be one volume of three dimensions; export it as one.")
    if min(shape[:3]) < 2:
        raise BadScan("This label map is a single slice; export the whole volume.")
    if np.prod(shape[:3], dtype=np.float64) > LABEL_MAP_VOXELS:
        raise TooLarge(f"This label map has more than the {LABEL_MAP_VOXELS:,} voxels allowed; resample it first.")


def _whole_numbers(values: NDArray[Any]) -> NDArray[Any]:
    """(I, J, K) of the voxels; BadScan for an image."""
    if values.ndim != 3:
        raise BadScan("This label map must be one volume of three dimensions; export it as one.")
    if values.dtype.kind not in "iu":
        rounded = np.round(values)
        if not np.isfinite(values).all() or not np.array_equal(values, rounded) or np.abs(rounded).max() > 65_535:
            raise BadScan(IMAGE)
        values = rounded.astype(np.int32)
    if len(np.unique(values)) > LABELS:
        raise BadScan(IMAGE)
    return values


def _body(found: LabelMap) -> Booleans:
    """(I, J, K) all that the air in front of the body does not reach."""
    background: NDArray[Any] = ndimage.label(found.labels == 0)[0]
    axis = int(np.abs(found.affine[1, :3]).argmax())
    front = 0 if found.affine[1, axis] > 0.0 else -1  # LPS: y grows to her back
    in_front: NDArray[Any] = background.take(front, axis=axis)
    counts = np.bincount(in_front[in_front > 0])
    if not counts.size or not (found.labels != 0).any():
        raise BadScan("This label map shows no skin with air in front of it; export the whole volume, 0 for air.")
    return np.asarray(background != counts.argmax())


def _lesions(found: LabelMap) -> Iterator[BallInside]:
    """By the segments' names, or where there are none by what is small, compact and inside."""
    cell = abs(float(np.linalg.det(found.affine[:3, :3])))
    numbers, counts = np.unique(found.labels, return_counts=True)
    voxels = {int(number): int(count) for number, count in zip(numbers, counts, strict=True) if number}
    if found.names:
        given = [number for number in voxels if NAMED_LESION.search(found.names.get(number, ""))]
    else:
        most = max(voxels.values(), default=0)  # the largest is tissue
        given = [number for number, count in voxels.items() if count < most and _radius(cell * count) < LARGEST_LESION]
        inner = ndimage.binary_erosion(found.labels != 0, border_value=1)
    balls = []
    for number in given:
        inside = found.labels == number
        if not found.names and not inner[inside].all():
            continue  # at the skin: a nipple, a marker
        parts: NDArray[Any] = ndimage.label(inside)[0]
        radii = _radius(cell * np.bincount(parts.ravel()))
        radii[0] = 0.0
        large = np.flatnonzero(radii >= SMALLEST_LESION)
        parts[(radii < SMALLEST_LESION)[parts]] = 0  # noise
        boxes = ndimage.find_objects(parts)
        fills = [float((parts[boxes[part - 1]] == part).mean()) / (np.pi / 6.0) for part in large]
        if not found.names and min(fills, default=0.0) < COMPACT:
            continue
        for part in large:
            if radii[part] > LARGEST_NAMED:
                continue
            corner = [side.start for side in boxes[part - 1]]
            centre = np.add(ndimage.center_of_mass(parts[boxes[part - 1]] == part), corner)
            name = found.names.get(number, f"Label {number}")
            name = name if len(large) == 1 else f"{name}, part {part}"
            balls.append(BallInside(name, (found.affine @ [*centre, 1.0])[:3], float(radii[part])))
    if len(balls) > LESIONS:
        raise BadScan(f"This label map has more than {LESIONS} lesions; leave out what is none.")
    yield from balls


def _radius(volumes: Any) -> Any:
    """Of balls of these volumes (numbers or an array)."""
    return np.cbrt(volumes * 3.0 / (4.0 * np.pi))


def _surface(body: Booleans, affine: Array) -> tuple[Array, Integers]:
    """(V, 3) mm and (F, 3), open where the volume ends."""
    from skimage.measure import marching_cubes  # 0.3 s to load, and hardly any scan is a volume

    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    steps = np.maximum(1, np.round(CELL / sizes)).astype(np.int64)
    padded = np.pad(body, [(0, int(-size % step)) for size, step in zip(body.shape, steps, strict=True)], "edge")
    blocks = padded.reshape([n for size, step in zip(padded.shape, steps, strict=True) for n in (size // step, step)])
    share = np.asarray(blocks.mean(axis=(1, 3, 5), dtype=np.float32))
    smooth = ndimage.gaussian_filter(share, SMOOTHING / (steps * sizes), mode="nearest")
    if not smooth.min() < 0.5 < smooth.max():
        raise BadScan("This label map shows no skin; export body and lesions with 0 for air.")
    places, faces, _, _ = marching_cubes(smooth, 0.5, allow_degenerate=False)  # type: ignore[no-untyped-call]
    indices = places.astype(np.float64) * steps + 0.5 * (steps - 1)
    vertices = indices @ affine[:3, :3].T + affine[:3, 3]
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces = faces[areas > SLIVER]
    is_mirrored = np.linalg.det(affine[:3, :3]) < 0.0
    return vertices, np.asarray(faces if is_mirrored else faces[:, ::-1], np.int64)
