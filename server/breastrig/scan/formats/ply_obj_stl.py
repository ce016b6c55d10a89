"""The meshes of an uploaded PLY, OBJ or STL.

Parsers stand behind checks of the sizes that the file announces.  A library takes what is there and leaves the rest
without a word, so the triangles that were found are counted against those that the file promises.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.file_type import BINARY_STL_HEADER, BINARY_STL_TRIANGLE, is_binary_stl
from breastrig.scan.formats.bare_points import obj_points, ply_points
from breastrig.scan.formats.obj import check_end, check_work, colours_as_shares, polygons, uniform_text
from breastrig.scan.formats.plain_meshes import plain_pieces
from breastrig.scan.formats.ply import as_binary, ply_header, text_rows
from breastrig.scan.limits import STL_SOLIDS, TRIANGLES, VERTICES
from breastrig.scan.piece import SEVERAL, Piece, Pieces


def mesh_pieces(data: bytes, kind: str, files: Mapping[str, bytes], texture: bool) -> Pieces:
    """What a ply, obj or stl file holds; `files` are those that it may name.

    Raises BadScan, or TooLarge when a limit is passed, each with a sentence.
    """
    data, promised, notes = {"ply": _ply, "obj": _obj, "stl": _stl}[kind](data)
    if promised == 0 and kind in ("ply", "obj"):
        return Pieces((), has_points=True, cloud=ply_points(data) if kind == "ply" else obj_points(data))
    try:
        found = plain_pieces(data, kind, texture)
        if found is None:
            from breastrig.scan.formats.library_meshes import library_pieces  # 0.4 s to load

            found = library_pieces(data, kind, files, texture)
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except BadInput:
        raise
    except Exception as error:  # a parser of untrusted bytes can raise anything
        raise damaged(kind) from error
    pieces = found.pieces
    if pieces and sum(len(piece.faces) for piece in pieces) < promised:
        raise damaged(kind)
    if kind == "obj" and pieces:
        check_end(data, sum(len(piece.vertices) for piece in pieces))
    if kind == "stl" and pieces:
        corners = np.concatenate([piece.vertices[piece.faces] for piece in pieces])
        pieces = (Piece(*_corners_joined(corners)),)
    return Pieces(pieces, found.has_points, (*notes, *found.notes) if texture else ())


def damaged(kind: str) -> BadScan:
    """The sentence for a file that breaks off or contradicts itself."""
    return BadScan(f"This {kind.upper()} file is damaged or cut off and cannot be read; export it again.")


class _Checked(NamedTuple):
    """A file that may be given to the library."""

    data: bytes
    triangles: int  # that it promises; polygons with more corners become several
    notes: tuple[str, ...] = ()


def _ply(data: bytes) -> _Checked:
    """With a header of our own."""
    try:
        header = ply_header(data)
    except (ValueError, IndexError) as error:
        raise damaged("ply") from error
    _check_sizes(header.count("face"), max(element.count for element in header.elements))
    if header.entries > len(data) - header.size:  # each takes a byte at least
        raise damaged("ply")
    notes = (SEVERAL,) if len(header.pictures) > 1 else ()
    if header.form != "ascii":
        return _Checked(header.written() + data[header.size :], header.count("face"), notes)
    rows = text_rows(data, header)
    if rows is None:
        raise damaged("ply")
    form, body = as_binary(rows, header) or ("ascii", b"\n".join([*rows, b""]))
    return _Checked(replace(header, form=form).written() + body, header.count("face"), notes)


def _obj(data: bytes) -> _Checked:
    """As uniform text."""
    data = colours_as_shares(uniform_text(data))
    faces = polygons(data)
    _check_sizes(faces, data.count(b"\nv "))
    check_work(data)
    return _Checked(data, faces)


def _stl(data: bytes) -> _Checked:
    """As it is; a text with plain line ends."""
    if is_binary_stl(data):
        triangles = (len(data) - BINARY_STL_HEADER) // BINARY_STL_TRIANGLE
        _check_sizes(triangles, 0)
        return _Checked(data, triangles)
    data = data.replace(b"\r", b"\n")
    text = data.lower()
    triangles, ends = text.count(b"endfacet"), text.count(b"endsolid")
    _check_sizes(triangles, 0)
    if ends > STL_SOLIDS:
        raise TooLarge(f"This STL file has more than the {STL_SOLIDS} parts allowed; join them.")
    if ends == 0 or text.rfind(b"endsolid") < text.rfind(b"endfacet"):
        raise damaged("stl")
    return _Checked(data, triangles)


def _check_sizes(triangles: int, vertices: int) -> None:
    """Sizes that the file itself announces, before anything of that size is allocated."""
    if triangles > TRIANGLES or vertices > VERTICES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")


def _corners_joined(triangles: Array) -> tuple[Array, Integers]:
    """(V, 3) vertices and (F, 3) faces of (F, 3, 3) corners.

    An STL repeats each corner for each triangle; equal ones become one again (exactly equal, float32).
    """
    vertices = triangles.reshape(-1, 3)
    with np.errstate(over="ignore"):  # ASCII may hold larger numbers; no torso has them, which read.py says
        single = vertices.astype(np.float32) + np.float32(0.0)
    exact = single.view(np.uint32).astype(np.uint64)
    first_two = (exact[:, 0] << np.uint64(32)) | exact[:, 1]
    order = np.lexsort((exact[:, 2], first_two))
    starts = np.ones(len(order), np.bool_)
    starts[1:] = (first_two[order][1:] != first_two[order][:-1]) | (exact[order, 2][1:] != exact[order, 2][:-1])
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    return vertices[order[starts]], group.reshape(-1, 3)
