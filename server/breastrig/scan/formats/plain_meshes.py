"""Binary PLY and STL files that hold nothing but arrays: most of what scanners write, and all that BreastRig does.

They are read as arrays at once, without loading a library for it.  Whatever is more than places, colours of eight bits
and triangles, or does not have the length that it announces, is left to the library.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.scan.file_type import BINARY_STL_HEADER, BINARY_STL_TRIANGLE, is_binary_stl
from breastrig.scan.formats.ply import BYTE_ORDERS, COLOURS, TYPES, Element, ply_header
from breastrig.scan.piece import Piece, Pieces

TEXTURE = frozenset(("texture_u", "texture_v", "u", "v", "s", "t"))  # names of what only a picture needs
CORNERS = ("vertex_index", "vertex_indices")


def plain_pieces(data: bytes, kind: str, texture: bool) -> Pieces | None:
    """The mesh of a ply or stl file whose header has been checked; None where the library is needed.

    `texture`: whether a picture is wanted too, with its coordinates.
    """
    if kind == "ply":
        return _ply(data, texture)
    return _stl(data) if kind == "stl" and is_binary_stl(data) else None


def _stl(data: bytes) -> Pieces | None:
    """Its triangles, each with three vertices of its own."""
    table = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    assert table.itemsize == BINARY_STL_TRIANGLE
    corners = np.frombuffer(data, table, offset=BINARY_STL_HEADER)["corners"]
    if not len(corners):
        return None
    vertices = corners.reshape(-1, 3).astype(np.float64)
    return Pieces((Piece(vertices, np.arange(len(vertices)).reshape(-1, 3)),))


def _ply(data: bytes, texture: bool) -> Pieces | None:
    header = ply_header(data)
    order = BYTE_ORDERS.get(header.form)
    if order is None or [element.name for element in header.elements] != ["vertex", "face"]:
        return None
    vertex, face = header.elements
    columns = _columns(vertex, order)
    corners = _corners(face, order)
    if columns is None or corners is None or not vertex.count or not face.count:
        return None
    if texture and (header.pictures or not TEXTURE.isdisjoint(columns.names or ())):
        return None
    ends = header.size + vertex.count * columns.itemsize
    if len(data) != ends + face.count * corners.itemsize:
        return None
    vertices = np.frombuffer(data, columns, vertex.count, header.size)
    triangles = np.frombuffer(data, corners, face.count, ends)
    if (triangles["count"] != 3).any():
        return None
    places = np.stack([vertices[axis] for axis in "xyz"], axis=1, dtype=np.float64)
    return Pieces((Piece(places, triangles["corners"].astype(np.int64), _colours(vertices)),))


def _columns(vertex: Element, order: str) -> np.dtype[Any] | None:
    """Of a row of a vertex; None when there is a list in it, a name twice, no place, or colours of another kind."""
    names = [words[-1] for words in vertex.properties]
    if len(set(names)) < len(names) or any(words[0] == "list" for words in vertex.properties):
        return None
    columns = {name: order + TYPES[words[0]][1:] for name, words in zip(names, vertex.properties, strict=True)}
    if not set("xyz") <= set(columns):
        return None
    coloured = [columns[name] for name in (*COLOURS, "alpha") if name in columns]
    if coloured and (not set(COLOURS) <= set(columns) or any(kind[1:] != "u1" for kind in coloured)):
        return None
    return np.dtype(list(columns.items()))


def _corners(face: Element, order: str) -> np.dtype[Any] | None:
    """Of a row of a triangle that has its corners and nothing else."""
    if len(face.properties) != 1 or face.properties[0][0] != "list" or face.properties[0][3] not in CORNERS:
        return None
    _, length, kind, _ = face.properties[0]
    if TYPES[kind][1] == "f":
        return None
    return np.dtype([("count", order + TYPES[length][1:]), ("corners", order + TYPES[kind][1:], 3)])


def _colours(vertices: NDArray[Any]) -> NDArray[np.uint8] | None:
    """(V, 3)"""
    if vertices.dtype.names is None or not set(COLOURS) <= set(vertices.dtype.names):
        return None
    return np.stack([vertices[name] for name in COLOURS], axis=1)
