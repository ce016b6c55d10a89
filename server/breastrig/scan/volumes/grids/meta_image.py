"""Reads MetaImage (.mha, or .mhd with its voxels in it)."""

import re
from collections.abc import Mapping

import numpy as np

from breastrig.core.errors import BadScan
from breastrig.scan.volumes.grids.attached import (
    DETACHED,
    HEADER_BYTES,
    NO_HEADER,
    decimal_numbers,
    voxels,
    whole_numbers,
)
from breastrig.scan.volumes.grids.frames import Frames, axis_codes, stated, unstated
from breastrig.scan.volumes.grids.grid import Grid, widest_axis
from breastrig.scan.volumes.volume import NOT_GREY, check_affine, check_shape

BAD_HEADER = NO_HEADER.format("MetaImage")
AS_TEXT = "The voxels of this MetaImage file are written as text; save it in binary."
NO_UNIT = "This MetaImage file has a unit of length that is not read; save it in mm."
NO_FRAME = "This MetaImage file does not say which side is left (its matrix and its AnatomicalOrientation {})"
TYPES = {"CHAR": "i1", "UCHAR": "u1", "SHORT": "i2", "USHORT": "u2", "INT": "i4", "UINT": "u4"}
TYPES |= {"LONG": "i4", "ULONG": "u4", "LONG_LONG": "i8", "ULONG_LONG": "u8", "FLOAT": "f4", "DOUBLE": "f8"}
SAME = {"rotation": "transformmatrix", "orientation": "transformmatrix", "position": "offset", "origin": "offset"}
SAME |= {"elementbyteordermsb": "binarydatabyteordermsb", "elementsize": "elementspacing"}
MM = {"mm": 1.0, "cm": 10.0, "um": 1e-3, "m": 1e3, "?": 1.0}
TRUE = ("true", "t", "1")
OPPOSITE = str.maketrans("RLAPSI", "LRPAIS")


def read_meta_image(data: bytes, frame: str | None) -> Grid:
    """The grid with its readings: one, or those among which a person has to choose.

    `frame` is the person's answer.  Raises BadScan or TooLarge; BadSettings for an answer that does not fit this file.
    """
    fields, start = _header(data)
    sizes = whole_numbers(fields.get("dimsize", "")) or ()
    if not sizes or min(sizes) < 1 or whole_numbers(fields.get("ndims", "")) != (len(sizes),):
        raise BadScan(BAD_HEADER)
    check_shape(sizes)
    if fields.get("elementnumberofchannels", "1") != "1":
        raise BadScan(NOT_GREY)
    frames = _frames(fields, sizes, frame)
    for each in frames[0]:
        check_affine(each.affine)
    kind = TYPES.get(fields.get("elementtype", "").upper().removeprefix("MET_"))
    if kind is None:
        raise BadScan(NOT_GREY if "elementtype" in fields else BAD_HEADER)
    dtype = np.dtype((">" if _is_true(fields, "binarydatabyteordermsb") else "<") + kind)
    raw = voxels(data, start, sizes, dtype, _is_true(fields, "compresseddata"))
    steps = np.linalg.norm(frames[0][0].affine[:3, :3], axis=0)
    return Grid((raw.reshape(sizes[:3], order="F"),), frames, slice_axis=widest_axis(steps))


def _header(data: bytes) -> tuple[Mapping[str, str], int]:
    """Fields by their one name in lower case, and where the voxels begin; BadScan where those are elsewhere."""
    start = data[:HEADER_BYTES]
    last = re.search(rb"(?:^|\n)[ \t]*ElementDataFile[ \t]*=[ \t]*([^\r\n]*)\r?(?:\n|$)", start, re.IGNORECASE)
    if last is None:
        raise BadScan(BAD_HEADER)
    if last.group(1).strip().upper() != b"LOCAL":
        raise BadScan(DETACHED.format(".mha"))
    fields = dict[str, str]()
    for line in start[: last.start()].decode("utf-8", "replace").splitlines():
        name, mark, value = line.partition("=")
        if mark:
            plain = name.strip().lower()
            fields.setdefault(SAME.get(plain, plain), value.strip())
    if "binarydata" in fields and not _is_true(fields, "binarydata"):
        raise BadScan(AS_TEXT)
    if fields.get("headersize", "0") not in ("0", ""):
        raise BadScan(BAD_HEADER)
    return fields, last.end()


def _is_true(fields: Mapping[str, str], name: str) -> bool:
    return fields.get(name, "").lower() in TRUE


def _frames(fields: Mapping[str, str], sizes: tuple[int, ...], frame: str | None) -> Frames:
    """ITK and all that build on it mean LPS, and write the sides that the axes come from beside the matrix.

    Where the two do not say the same, another program had another frame in mind.
    """
    mm = MM.get(fields.get("distanceunits", "mm").lower())
    if mm is None:
        raise BadScan(NO_UNIT)
    steps = decimal_numbers(fields.get("elementspacing", "")) or []
    turn = decimal_numbers(fields.get("transformmatrix", "")) or []
    offset = decimal_numbers(fields.get("offset", "")) or []
    if len(steps) < 3 or min(steps[:3]) <= 0.0:
        raise BadScan("This MetaImage file does not say how large its voxels are; save it again.")
    spacing, came_from = mm * np.array(steps[:3]), fields.get("anatomicalorientation", "???").upper()
    if len(turn) != len(sizes) ** 2 or len(offset) != len(sizes):
        return unstated(NO_FRAME.format("are not both there"), spacing, sizes[:3], frame)
    rows = np.reshape(turn, (len(sizes), len(sizes)))[:3, :3]  # a row for each axis
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = rows.T * spacing, mm * np.array(offset[:3])
    check_affine(affine)
    if axis_codes(affine).translate(OPPOSITE) != came_from[:3]:
        why = "are not both there" if "?" in came_from else "contradict each other"
        return unstated(NO_FRAME.format(why), spacing, sizes[:3], frame)
    return stated(affine, frame)
