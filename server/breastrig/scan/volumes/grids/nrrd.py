"""Reads NRRD with its voxels attached, also segmentations of 3D Slicer (.seg.nrrd), whose segments may overlap."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan
from breastrig.scan.limits import LABELS
from breastrig.scan.volumes.codes import coded_as, label_of
from breastrig.scan.volumes.grids.attached import (
    DETACHED,
    HEADER_BYTES,
    NO_HEADER,
    decimal_numbers,
    voxels,
    whole_numbers,
)
from breastrig.scan.volumes.grids.frames import Frames, stated, unstated
from breastrig.scan.volumes.grids.grid import Described, Grid, widest_axis
from breastrig.scan.volumes.volume import NOT_GREY, check_affine, check_shape

BAD_HEADER = NO_HEADER.format("NRRD")
NO_FRAME = "This NRRD file does not say which side is left (it names no patient space)"
NO_ORIGIN = "The file names no origin; its first voxel was put at 0."
NO_UNIT = "This NRRD file has a unit of length that is not read; save it in mm."
OTHER_ENCODING = "The voxels of this NRRD file are neither raw nor packed with gzip; save it in one of both."
SKIPS = "This NRRD file leaves out bytes before its voxels, which is not read; save it again."
NO_ORDER = "This NRRD file does not name the order of its bytes (endian); save it again."
TO_LPS = {  # of each space, what its axes are multiplied by
    "right-anterior-superior": (-1.0, -1.0, 1.0),
    "left-anterior-superior": (1.0, -1.0, 1.0),
    "left-posterior-superior": (1.0, 1.0, 1.0),
}
TO_LPS |= {"".join(word[0] for word in name.split("-")): signs for name, signs in TO_LPS.items()}
MM = {"mm": 1.0, "millimeter": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "": 1.0}
WORDS_OF_TYPES = {
    "i1": ("signed char", "int8", "int8_t"),
    "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
    "i4": ("int", "signed int", "int32", "int32_t"),
    "u4": ("uint", "unsigned int", "uint32", "uint32_t"),
    "i8": ("longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"),
    "u8": ("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"),
    "f4": ("float",),
    "f8": ("double",),
}
TYPES = {word: kind for kind, words in WORDS_OF_TYPES.items() for word in words}
VECTOR = re.compile(r"\(([^()]*)\)|(none)")
QUOTED = re.compile(r'"([^"]*)"')
Fields = Mapping[str, str]


def read_nrrd(data: bytes, frame: str | None) -> Grid:
    """The grid with its readings: one, or those among which a person has to choose.

    `frame` is the person's answer.  Raises BadScan or TooLarge; BadSettings for an answer that does not fit this file.
    """
    fields, words, start = _header(data)
    sizes = whole_numbers(fields.get("sizes", "")) or ()
    if not sizes or min(sizes) < 1 or whole_numbers(fields.get("dimension", "")) != (len(sizes),):
        raise BadScan(BAD_HEADER)
    directions = _directions(fields, sizes)
    inner = [axis for axis, each in enumerate(directions) if each is not None]
    lists = [axis for axis in range(len(sizes)) if axis not in inner and sizes[axis] > 1]
    described = _described(words, sizes[lists[0]] if lists else 1)
    if lists and not (len(lists) == 1 and described and sizes[lists[0]] <= LABELS):
        if re.search(r"color|vector|matrix|complex|quaternion", fields.get("kinds", "")):
            raise BadScan(NOT_GREY)
        inner = inner + lists  # more than three
    shape = tuple(sizes[axis] for axis in inner)
    check_shape(shape)
    columns = np.array([directions[axis] for axis in inner[:3]], np.float64).T
    frames = _frames(fields, columns, shape, frame)
    for each in frames[0]:
        check_affine(each.affine)
    raw = voxels(data, start, sizes, _dtype(fields), fields.get("encoding", "").lower() in ("gzip", "gz"))
    layers = tuple(_layer(raw, lists, inner, at) for at in range(sizes[lists[0]] if lists else 1))
    steps = np.linalg.norm(frames[0][0].affine[:3, :3], axis=0)
    return Grid(layers, frames, slice_axis=widest_axis(steps), described=described)


def _header(data: bytes) -> tuple[Fields, Fields, int]:
    """Fields, keys with values, and where the voxels begin; BadScan for a header without voxels after it."""
    end = re.search(rb"\r?\n\r?\n", data[:HEADER_BYTES])
    text = data[: end.start() if end else HEADER_BYTES].decode("utf-8", "replace")
    fields, words = dict[str, str](), dict[str, str]()
    for line in text.splitlines()[1:]:
        key, mark, value = line.partition(":=")
        if mark and ": " not in key:
            words[key.strip()] = value
            continue
        name, mark, value = line.partition(":")
        if mark and not line.startswith("#"):
            fields[re.sub(r"\s", "", name).lower()] = value.strip()
    if "datafile" in fields:
        raise BadScan(DETACHED.format(".nrrd"))
    if end is None:
        raise BadScan(BAD_HEADER)
    if any(fields.get(name, "0") != "0" for name in ("lineskip", "byteskip")):
        raise BadScan(SKIPS)
    if fields.get("encoding", "").lower() not in ("raw", "gzip", "gz"):
        raise BadScan(OTHER_ENCODING)
    return fields, words, end.end()


def _dtype(fields: Fields) -> np.dtype[Any]:
    kind = TYPES.get(" ".join(fields.get("type", "").lower().split()))
    if kind is None:
        raise BadScan(NOT_GREY if fields.get("type") == "block" else BAD_HEADER)
    order = {"little": "<", "big": ">"}.get(fields.get("endian", "little" if kind.endswith("1") else "").lower())
    if order is None:
        raise BadScan(NO_ORDER)
    return np.dtype(order + kind)


def _directions(fields: Fields, sizes: tuple[int, ...]) -> list[Array | None]:
    """(3,) of each axis in the file's space and unit; None of one that is not in space."""
    if "spacedirections" in fields:
        found = [
            None if none else decimal_numbers(vector.replace(",", " "))
            for vector, none in VECTOR.findall(fields["spacedirections"])
        ]
        if len(found) != len(sizes) or any(each is not None and len(each) != 3 for each in found):
            raise BadScan(BAD_HEADER)
        return [None if each is None else np.array(each) for each in found]
    steps = decimal_numbers(fields.get("spacings", "")) or [float("nan")] * len(sizes)
    if len(steps) != len(sizes):
        raise BadScan(BAD_HEADER)
    inner = [axis for axis, step in enumerate(steps) if not np.isnan(step)]
    inner = (inner if len(inner) >= 3 else [axis for axis, size in enumerate(sizes) if size > 1])[:3]
    units = np.eye(3)
    return [steps[axis] * units[inner.index(axis)] if axis in inner else None for axis in range(len(sizes))]


def _frames(fields: Fields, columns: Array, shape: tuple[int, ...], frame: str | None) -> Frames:
    """`columns` (3, 3) of the three axes."""
    units = {each.strip().lower() for each in QUOTED.findall(fields.get("spaceunits", ""))}
    if len(units) > 1 or not units <= MM.keys():
        raise BadScan(NO_UNIT)
    mm = MM[next(iter(units), "mm")]
    space = fields.get("space", "").lower().removesuffix("-time").strip()
    signs = TO_LPS.get(space)
    if signs is None or "spacedirections" not in fields:
        return unstated(NO_FRAME, mm * np.linalg.norm(columns, axis=0), shape, frame)
    origin = decimal_numbers(re.sub(r"[(),]", " ", fields.get("spaceorigin", ""))) or []
    is_placed = len(origin) == 3 and bool(np.isfinite(origin).all())
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = mm * columns, mm * np.array(origin) if is_placed else 0.0
    affine = np.diag([*signs, 1.0]) @ affine
    check_affine(affine)
    readings, doubt, notes = stated(affine, frame, is_placed)
    return readings, doubt, notes if is_placed else (*notes, NO_ORIGIN)


def _layer(raw: NDArray[Any], lists: list[int], inner: list[int], at: int) -> NDArray[Any]:
    """(I, J, K) one layer of the numbers."""
    chosen = tuple(slice(None) if axis in inner else at if axis in lists else 0 for axis in range(raw.ndim))
    return np.asarray(raw[chosen])


def _described(words: Fields, layers: int) -> dict[tuple[int, int], Described]:
    """The segments of 3D Slicer by layer and label; without numbers of their own they are counted."""
    found = dict[tuple[int, int], tuple[str, str]]()
    for at in range(LABELS * LABELS):
        if f"Segment{at}_ID" not in words and f"Segment{at}_Name" not in words:
            break
        layer, label = (
            whole_numbers(words.get(f"Segment{at}_{name}", default)) or (-1,)
            for name, default in (("Layer", str(at if layers > 1 else 0)), ("LabelValue", "1"))
        )
        found.setdefault((layer[0], label[0]), (words.get(f"Segment{at}_Name", ""), words.get(f"Segment{at}_Tags", "")))
    are_numbers = len({label for _, label in found}) == len(found)
    return {
        place: _segment(place[1] if are_numbers else count, *said)
        for count, (place, said) in enumerate(found.items(), 1)
    }


def _segment(number: int, name: str, tags: str) -> Described:
    """Its tag is `TerminologyEntry:CONTEXT~SCHEME^CODE^MEANING~SCHEME^CODE^MEANING~...`, of category and type."""
    entry = re.search(r"TerminologyEntry:([^|]*)", tags)
    parts = [each.split("^") for each in entry.group(1).split("~")[1:3]] if entry else []
    category, kind = ([*parts, [], []])[:2]
    label = label_of((name, *kind[2:3]))
    return Described(number, label, coded_as(set(category[1:2]), set(kind[1:2])))
