"""The PLY files that nearly all scanners write: binary, places and perhaps colours of vertices, triangles.

They are two tables of fixed width, read without the library that takes 0.4 s to load.  Whatever is the least bit
different (text, quads, textures, colours of triangles, a wrong length) is left to ply_obj_stl.py, with its checks and
its sentences.
"""

import numpy as np

from breastrig.scan.formats.ply import TYPES, Element, PlyHeader, ply_header
from breastrig.scan.limits import TRIANGLES, VERTICES
from breastrig.scan.piece import Piece, Pieces

PLACE, COLOUR = ("x", "y", "z"), ("red", "green", "blue")
PASSED_OVER = {"nx", "ny", "nz", "alpha", "quality", "confidence", "intensity"}
CORNERS = ("vertex_indices", "vertex_index")


def plain_ply(data: bytes) -> Pieces | None:
    """The one mesh of a plain binary PLY; None for any other, and for whatever is wrong with one."""
    try:
        header = ply_header(data)
    except (ValueError, IndexError):
        return None
    if header.form == "ascii" or header.pictures or [element.name for element in header.elements] != ["vertex", "face"]:
        return None
    if not 0 < header.count("face") <= TRIANGLES or not 0 < header.count("vertex") <= VERTICES:
        return None
    vertex, face = (_columns(element, header) for element in header.elements)
    if vertex is None or face is None:
        return None
    begin, middle = header.size, header.size + vertex.itemsize * header.count("vertex")
    if len(data) != middle + face.itemsize * header.count("face"):
        return None
    rows = np.frombuffer(data[begin:middle], vertex)
    table = np.frombuffer(data[middle:], face)
    if (table["length"] != 3).any():
        return None
    vertices = np.stack([rows[name] for name in PLACE], axis=1).astype(np.float64)
    faces = np.ascontiguousarray(table["corners"], dtype=np.int64)
    if faces.min() < 0 or faces.max() >= len(vertices):
        return None
    colours = np.stack([rows[name] for name in COLOUR], axis=1) if COLOUR[0] in (vertex.names or ()) else None
    return Pieces((Piece(vertices, faces, colours=colours),))


def _columns(element: Element, header: PlyHeader) -> np.dtype[np.void] | None:
    """The table's columns; None when it is not plain."""
    order = ">" if header.form == "binary_big_endian" else "<"
    types = {name: order + kind[1:] for name, kind in TYPES.items()}
    names = [words[-1] for words in element.properties]
    if element.name == "face":
        if len(names) != 1 or names[0] not in CORNERS or element.properties[0][0] != "list":
            return None
        _, length, kind, _ = element.properties[0]
        if "f" in types[length] or "f" in types[kind]:
            return None
        return np.dtype([("length", types[length]), ("corners", types[kind], 3)])
    if any(words[0] == "list" for words in element.properties) or len(set(names)) < len(names):
        return None
    kinds = dict(zip(names, (types[words[0]] for words in element.properties), strict=True))
    if not {*PLACE} <= kinds.keys() or not kinds.keys() <= {*PLACE, *COLOUR} | PASSED_OVER:
        return None
    coloured = [name for name in (*COLOUR, "alpha") if name in kinds]
    if coloured and (not {*COLOUR} <= {*coloured} or any(kinds[name][1:] != "u1" for name in coloured)):
        return None
    return np.dtype(list(kinds.items()))
