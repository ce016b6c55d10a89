"""The grey values of DICOM slices, of one size and scale; uncompressed ones, and what pydicom has a decoder for."""

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.errors import BadInput, BadScan
from breastrig.scan.images.dicom_headers import Slice
from breastrig.scan.images.dicom_series import Stack
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.volumes.dicom_seg import DAMAGED, plain_dicom
from breastrig.scan.volumes.unlogged import unlogged
from breastrig.scan.volumes.volume import frame_digest

COMPRESSED = (
    "The pixels of these DICOM images are compressed in a way ({}) for which no decoder is installed; install "
    "python-gdcm beside breastrig[mri], or export them uncompressed."
)
BITS = (8, 16, 32)
MOST_PACKED = 2  # bytes of a compressed slice over those of its pixels; more are not what they say
TAGS = (
    "Rows",
    "Columns",
    "NumberOfFrames",
    "SamplesPerPixel",
    "PhotometricInterpretation",
    "BitsAllocated",
    "BitsStored",
    "HighBit",
    "PixelRepresentation",
    "PixelData",
    "ExtendedOffsetTable",
    "ExtendedOffsetTableLengths",
)


def volume_of(stack: Stack) -> ImageVolume:
    """The voxels.  BadScan where a file is damaged or compressed in a way that is not read."""
    scales = {(each.slope, each.intercept) for each in stack.slices}
    values: NDArray[Any] | None = None
    reader = _Reader()
    for each, at in zip(stack.slices, stack.index.tolist(), strict=True):
        stored = reader.pixels(each)
        if values is None:
            is_float = len(scales) > 1 or each.slope <= 0.0 or stored.dtype.itemsize > 2
            kind = np.dtype(np.float32) if is_float else stored.dtype
            values = np.zeros(stack.shape[::-1], kind)
        if stored.dtype != values.dtype and not is_float:
            raise BadScan("The slices of this DICOM series differ in how their pixels are stored; export it again.")
        values[at] = each.slope * stored.astype(np.float32) + each.intercept if is_float else stored
    assert values is not None
    if stack.slices[0].is_inverted:
        values = values.max() - values if is_float else (int(values.max()) - values.astype(np.int32)).astype(np.int32)
    for at in stack.bridged:
        values[at] = 0.5 * values[at - 1] + 0.5 * values[at + 1]
    frame = frame_digest(stack.slices[0].reference)
    stances = {each.stance for each in stack.slices}
    stance = stances.pop() if len(stances) == 1 else None
    return ImageVolume(values.transpose(2, 1, 0), stack.affine, frame, stack.gaps, stack.notes, stance)


def middle_of(stack: Stack) -> NDArray[Any] | None:
    """(R, C) pixels of the slice in the middle; None where they cannot be read."""
    middle = stack.slices[len(stack.slices) // 2]
    try:
        stored = _Reader().pixels(middle)
    except BadInput:
        return None
    return stored.max() - stored if middle.is_inverted else stored


class _Reader:
    """Reads pixels; a file of many frames is parsed once."""

    def __init__(self) -> None:
        self._file: Any = None
        self._dataset: Any = None

    def pixels(self, of: Slice) -> NDArray[Any]:
        """(R, C) as they are stored, whole numbers.  BadScan."""
        try:
            with unlogged():
                if self._file is not of.file:
                    self._dataset, self._file = _parsed(of.file.whole()), of.file
                return _stored(self._dataset, of)
        except BadInput:
            raise
        except Exception as error:  # it can raise anything
            raise BadScan(DAMAGED) from error


def _parsed(data: bytes) -> Any:
    from pydicom.datadict import tag_for_keyword
    from pydicom.filereader import read_partial

    tags = [tag for name in TAGS if (tag := tag_for_keyword(name)) is not None]
    return read_partial(io.BytesIO(plain_dicom(data)), None, force=True, specific_tags=list(tags))


def _stored(dataset: Any, of: Slice) -> NDArray[Any]:
    bits = int(dataset.BitsAllocated)
    if bits not in BITS or (int(dataset.Rows), int(dataset.Columns)) != (of.rows, of.columns):
        raise BadScan(DAMAGED)
    used, is_signed = int(dataset.get("BitsStored", bits)), int(dataset.get("PixelRepresentation", 0)) == 1
    high = int(dataset.get("HighBit", used - 1))
    if not 0 < used <= bits or not used - 1 <= high < bits:
        raise BadScan(DAMAGED)
    syntax = dataset.file_meta.get("TransferSyntaxUID", None) if hasattr(dataset, "file_meta") else None
    size = of.rows * of.columns
    if syntax is not None and syntax.is_encapsulated:
        return _decoded(dataset, of, bits, syntax)
    content = dataset.PixelData
    if len(content) < (of.frame + 1) * size * bits // 8:
        raise BadScan(DAMAGED)
    order = "<" if dataset.original_encoding[1] is not False else ">"
    kind = np.dtype(f"{order}{'i' if is_signed else 'u'}{bits // 8}")
    raw = np.frombuffer(content, kind, size, of.frame * size * bits // 8).reshape(of.rows, of.columns)
    if used < bits:  # what is beside the stored bits is no part of the picture
        raw = (raw << (bits - 1 - high)) >> (bits - used)
    return raw.astype(kind.newbyteorder("="), copy=False)


def _decoded(dataset: Any, of: Slice, bits: int, syntax: Any) -> NDArray[Any]:
    from pydicom.encaps import get_frame
    from pydicom.pixels.utils import iter_pixels

    packed = get_frame(dataset.PixelData, of.frame, number_of_frames=of.frames)
    if len(packed) > MOST_PACKED * of.rows * of.columns * bits // 8 + 4096:
        raise BadScan(DAMAGED)
    try:
        found = np.asarray(next(iter(iter_pixels(dataset, indices=[of.frame], raw=True))))
    except (RuntimeError, NotImplementedError) as error:  # no decoder for it, or none could
        raise BadScan(COMPRESSED.format(_shown(syntax))) from error
    if found.shape != (of.rows, of.columns):
        raise BadScan(DAMAGED)
    return found


def _shown(syntax: Any) -> str:
    name = str(syntax.name)
    return name.split(",")[0].split("(")[0].strip()[:40]
