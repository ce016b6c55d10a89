"""The points of PLY and OBJ files that hold no triangles."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan
from breastrig.scan.formats.obj import POINT
from breastrig.scan.formats.ply import BYTE_ORDERS, COLOURS, TYPES, ply_header
from breastrig.scan.piece import PointCloud

SPLATS = (
    "This PLY holds a cloud of Gaussian splats, which is a picture and no surface; "
    "export the mesh or the point cloud of this scan."
)
SPLAT_COLUMN = "f_dc_0"
NO_POINTS = "This scan has no triangles; export it as a triangle mesh."
DAMAGED = "This PLY file is damaged or cut off and cannot be read; export it again."


def ply_points(data: bytes) -> PointCloud:
    """Of a PLY whose header has been checked and written anew, as binary if all its rows are alike."""
    header = ply_header(data)
    at = header.size
    for element in header.elements:
        names = [words[-1] for words in element.properties]
        has_list = any(words[0] == "list" for words in element.properties)
        if element.name == "vertex":
            break
        if element.count and has_list:
            raise BadScan(DAMAGED)
        at += element.count * sum(np.dtype(TYPES[words[0]]).itemsize for words in element.properties if not has_list)
    else:
        raise BadScan(NO_POINTS)
    if SPLAT_COLUMN in names:
        raise BadScan(SPLATS)
    if header.form not in BYTE_ORDERS or has_list or len(set(names)) < len(names) or not set("xyz") <= set(names):
        raise BadScan(NO_POINTS if not element.count else DAMAGED)
    order = BYTE_ORDERS[header.form]
    row = np.dtype([(words[-1], order + TYPES[words[0]][1:]) for words in element.properties])
    if len(data) < at + element.count * row.itemsize:
        raise BadScan(DAMAGED)
    rows = np.frombuffer(data, row, element.count, at)
    normals = _columns(rows, ("nx", "ny", "nz")) if {"nx", "ny", "nz"} <= set(names) else None
    return PointCloud(_columns(rows, tuple("xyz")), normals, _colours(rows) if set(COLOURS) <= set(names) else None)


def obj_points(data: bytes) -> PointCloud:
    """Of an OBJ in uniform text, colours from 0 to 1 behind the places."""
    words = [line.split()[1:7] for line in POINT.findall(data)]
    try:
        points = np.array([each[:3] for each in words], np.float64).reshape(-1, 3)
        coloured = bool(words) and all(len(each) == 6 for each in words)
        shares = np.array([each[3:] for each in words], np.float64) if coloured else None
    except ValueError as error:
        raise BadScan("This OBJ file is damaged or cut off and cannot be read; export it again.") from error
    colours = None if shares is None else np.round(255.0 * np.clip(np.nan_to_num(shares), 0.0, 1.0)).astype(np.uint8)
    return PointCloud(points, None, colours)


def _columns(rows: NDArray[Any], names: tuple[str, ...]) -> Array:
    with np.errstate(all="ignore"):
        return np.stack([rows[name].astype(np.float64) for name in names], axis=1)


def _colours(rows: NDArray[Any]) -> NDArray[np.uint8]:
    """(N, 3) of bytes, of larger whole numbers up to their maximum, or of shares of one."""
    first = rows[COLOURS[0]].dtype
    full = 1.0 if first.kind == "f" else float(np.iinfo(first).max)
    shares = np.clip(np.nan_to_num(_columns(rows, COLOURS)) / full, 0.0, 1.0)
    return np.asarray(np.round(255.0 * shares).astype(np.uint8))
