"""Clouds of points in the Point Cloud Library's format: as text, as binary rows, or packed column by column (LZF).

The header says fields with their sizes and kinds, the number of points, and the place of the sensor.  The format is a
page long, and those who read it elsewhere bring the whole library or trust the sizes that a file announces.
"""

import re
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import PCD_FIELDS, PCD_HEADER_BYTES, POINTS, TOO_MANY_POINTS
from breastrig.scan.piece import PointCloud, colour_bytes

DATA = re.compile(rb"(?mi)^[ \t]*DATA[ \t]+(ascii|binary_compressed|binary)[ \t]*\r?\n")
KINDS = {"F4": "<f4", "F8": "<f8", "U1": "<u1", "U2": "<u2", "U4": "<u4", "U8": "<u8"}
KINDS |= {"I1": "<i1", "I2": "<i2", "I4": "<i4", "I8": "<i8"}
COLOURS = (("r", "g", "b"), ("red", "green", "blue"))
DAMAGED = "This PCD file is damaged or cut off and cannot be read; export it again."


@dataclass(frozen=True)
class _Header:
    row: np.dtype[np.void]
    count: int
    form: bytes  # ascii, binary or binary_compressed
    sensor: Array | None  # (3,)
    size: int  # bytes before the data


def pcd_points(data: bytes) -> PointCloud:
    """The points of a PCD file.  BadScan or TooLarge with a sentence."""
    try:
        header = _header(data)
        rows = {b"ascii": _text, b"binary": _binary, b"binary_compressed": _packed}[header.form](data, header)
        with np.errstate(all="ignore"):  # what is no number is left out, whichever kind of it
            return _cloud(rows, header.sensor)
    except (ValueError, IndexError, KeyError, TypeError, struct.error, OverflowError) as error:
        raise BadScan(DAMAGED) from error


def _header(data: bytes) -> _Header:
    found = DATA.search(data, 0, PCD_HEADER_BYTES)
    if found is None:
        raise ValueError("no data")
    words: dict[str, list[str]] = {}
    for line in data[: found.start()].decode("latin-1").splitlines():
        name, *values = line.split() or [""]
        words[name.upper()] = values
    names = words.get("FIELDS") or words["COLUMNS"]
    counts = [_whole(word) for word in words.get("COUNT", ["1"] * len(names))]
    kinds = [KINDS[kind.upper() + size] for kind, size in zip(words["TYPE"], words["SIZE"], strict=True)]
    if len(names) > PCD_FIELDS or max(counts) > PCD_FIELDS:
        raise ValueError("far more than a point has")
    columns = [
        (f"{index} {name}", kind, (count,))
        for index, (name, kind, count) in enumerate(zip(names, kinds, counts, strict=True))
    ]
    points = _whole(words["POINTS"][0]) if "POINTS" in words else _whole(words["WIDTH"][0]) * _whole(words["HEIGHT"][0])
    if points > POINTS:
        raise TooLarge(TOO_MANY_POINTS)
    view = np.array(words.get("VIEWPOINT", [])[:3], np.float64)
    sensor = view if view.shape == (3,) and np.isfinite(view).all() else None
    return _Header(np.dtype(columns), points, found[1].lower(), sensor, found.end())


def _whole(word: str) -> int:
    if not re.fullmatch(r"\d{1,15}", word):
        raise ValueError("a count that is none")
    return int(word)


def _text(data: bytes, header: _Header) -> NDArray[np.void]:
    lines = [line for line in data[header.size :].split(b"\n") if line.strip()][: header.count]
    width = sum(kind[0].itemsize // kind[0].base.itemsize for kind in (header.row.fields or {}).values())
    numbers = np.array([line.split() for line in lines], np.float64)
    if numbers.shape != (header.count, width):
        raise ValueError("too few numbers")
    rows, at = np.zeros(header.count, header.row), 0
    for name in header.row.names or ():
        length = rows[name].shape[1]
        with np.errstate(all="ignore"):  # numbers that are too large for their column are found afterwards
            rows[name] = numbers[:, at : at + length]
        at += length
    return rows


def _binary(data: bytes, header: _Header) -> NDArray[np.void]:
    return np.frombuffer(data, header.row, header.count, header.size)


def _packed(data: bytes, header: _Header) -> NDArray[np.void]:
    """The points of packed data: one column after the other, all compressed together."""
    packed, whole = struct.unpack_from("<II", data, header.size)
    if whole != header.count * header.row.itemsize or header.size + 8 + packed > len(data):
        raise ValueError("another size than that of its points")
    content = unpack_lzf(data[header.size + 8 : header.size + 8 + packed], whole)
    rows, at = np.zeros(header.count, header.row), 0
    for name in header.row.names or ():
        column = rows[name]
        rows[name] = np.frombuffer(content, column.dtype, column.size, at).reshape(column.shape)
        at += column.nbytes
    return rows


def unpack_lzf(packed: bytes, size: int) -> bytes:
    """The LZF-decompressed bytes: literal runs and back references. ValueError where it is not of `size` bytes."""
    found, at, end = bytearray(), 0, len(packed)
    while at < end and len(found) <= size:
        control = packed[at]
        at += 1
        if control < 32:
            found += packed[at : at + control + 1]
            at += control + 1
            continue
        length, back = control >> 5, (control & 31) << 8
        if length == 7:
            length += packed[at]
            at += 1
        back += packed[at] + 1
        at += 1
        length += 2
        start = len(found) - back
        if start < 0:
            raise ValueError("a repetition of nothing")
        if back >= length:
            found += found[start : start + length]
        else:
            found += (bytes(found[start:]) * (length // back + 1))[:length]
    if len(found) != size:
        raise ValueError("another size than announced")
    return bytes(found)


def _cloud(rows: NDArray[np.void], sensor: Array | None) -> PointCloud:
    columns = {name.split(" ", 1)[1].lower(): rows[name][:, 0] for name in reversed(rows.dtype.names or ())}
    points = np.stack([columns[axis] for axis in "xyz"], axis=1).astype(np.float64)
    seen = np.isfinite(points).all(axis=1)  # what the sensor did not see has a place in the file that is no number
    normals = None
    if {"normal_x", "normal_y", "normal_z"} <= set(columns):
        normals = np.stack([columns[f"normal_{axis}"] for axis in "xyz"], axis=1).astype(np.float64)[seen]
    packed = columns.get("rgb", columns.get("rgba"))
    colours = None
    if packed is not None and packed.dtype.itemsize == 4:
        whole = np.ascontiguousarray(packed).view("<u4")[seen]
        colours = np.stack([whole >> 16 & 255, whole >> 8 & 255, whole & 255], axis=1).astype(np.uint8)
    else:
        names = next((names for names in COLOURS if set(names) <= set(columns)), None)
        if names is not None:
            kind = columns[names[0]].dtype
            largest = float(np.iinfo(kind).max) if kind.kind in "iu" and kind.itemsize == 1 else None
            colours = colour_bytes(
                np.stack([columns[name] for name in names], axis=1).astype(np.float64)[seen], largest
            )
    return PointCloud(points[seen], normals, colours, sensor)
