"""Files of nothing but arrays, read without a library: the same as the library reads, and nothing else is tried."""

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.scan.formats.library_meshes import library_pieces
from breastrig.scan.formats.plain_meshes import plain_pieces
from breastrig.scan.piece import Piece

SIZES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "uint": "u4", "short": "i2", "ushort": "u2"}
PLACES = (("float", "x"), ("float", "y"), ("float", "z"))
COLOURS = (("uchar", "red"), ("uchar", "green"), ("uchar", "blue"))
CORNERS = "list uchar int vertex_indices"


def ply(vertex: tuple = PLACES, face: str = CORNERS, form: str = "binary_little_endian", more: str = "") -> bytes:
    """A toy's surface with these properties of a vertex (type, name), those that are no places made up."""
    rig, rng = toy_rig(), np.random.default_rng(5)
    order = "<" if form == "binary_little_endian" else ">"
    rows = np.zeros(len(rig.template), [(name, order + SIZES[kind]) for kind, name in vertex])
    for _, name in vertex:
        known = name in ("x", "y", "z")
        rows[name] = rig.template[:, "xyz".index(name)] if known else rng.integers(0, 256, len(rows))
    _, length, kind, _ = face.split()[:4]
    triangles = np.zeros(len(rig.faces), [("n", order + SIZES[length]), ("at", order + SIZES[kind], 3)])
    triangles["n"], triangles["at"] = 3, rig.faces
    lines = [f"format {form} 1.0", f"element vertex {len(rows)}", *(f"property {a} {b}" for a, b in vertex), more]
    lines += [f"element face {len(triangles)}", f"property {face}", "end_header"]
    return "\n".join(["ply", *(line for line in lines if line), ""]).encode() + rows.tobytes() + triangles.tobytes()


def stl() -> bytes:
    """The same surface."""
    rig = toy_rig()
    rows = np.zeros(len(rig.faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = rig.template[rig.faces]
    return b"a title".ljust(80) + len(rows).to_bytes(4, "little") + rows.tobytes()


def assert_same(ours: Piece, library: Piece) -> None:
    np.testing.assert_array_equal(ours.vertices, library.vertices)
    np.testing.assert_array_equal(ours.faces, library.faces)
    assert ours.vertices.dtype == np.float64
    assert ours.faces.dtype == np.int64
    assert (ours.colours is None) == (library.colours is None)
    if ours.colours is not None and library.colours is not None:
        np.testing.assert_array_equal(ours.colours, library.colours)


READ = {
    "places": ply(),
    "doubles": ply((("double", "x"), ("double", "y"), ("double", "z"))),
    "other order": ply((("float", "z"), ("float", "y"), ("float", "x"))),
    "normals": ply((*PLACES, ("float", "nx"), ("float", "ny"), ("float", "nz"))),
    "colours": ply((*PLACES, *COLOURS)),
    "colours with alpha": ply((*PLACES, *COLOURS, ("uchar", "alpha"))),
    "other numbers between": ply((("int", "quality"), *PLACES, ("ushort", "label"), *COLOURS)),
    "unsigned corners": ply(face="list int uint vertex_index"),
    "other byte order": ply((*PLACES, *COLOURS), form="binary_big_endian"),
}


@pytest.mark.parametrize("name", READ)
def test_a_ply_of_arrays_is_read_as_the_library_reads_it(name: str) -> None:
    found, library = plain_pieces(READ[name], "ply", True), library_pieces(READ[name], "ply", {}, True)
    assert found is not None
    assert found.notes == library.notes == ()
    assert not found.has_points
    (ours,), (theirs,) = found.pieces, library.pieces
    assert_same(ours, theirs)


def test_a_binary_stl_is_read_as_the_library_reads_it() -> None:
    found, library = plain_pieces(stl(), "stl", True), library_pieces(stl(), "stl", {}, True)
    assert found is not None
    ours, theirs = found.pieces[0], library.pieces[0]
    np.testing.assert_array_equal(ours.vertices[ours.faces], theirs.vertices[theirs.faces])


LEFT = {
    "a picture's places": ply((*PLACES, ("float", "s"), ("float", "t"))),
    "a picture's name": ply(more="comment TextureFile skin.png"),
    "colours in other numbers": ply((*PLACES, ("float", "red"), ("float", "green"), ("float", "blue"))),
    "half a colour": ply((*PLACES, ("uchar", "red"), ("uchar", "green"), ("uchar", "alpha"))),
    "another element": ply(more="element camera 0\nproperty float zoom"),
    "corners under another name": ply(face="list uchar int corners"),
    "cut off": ply()[:-1],
    "too long": ply() + b"\0",
    "text": ply().replace(b"binary_little_endian", b"ascii"),
}


@pytest.mark.parametrize("name", LEFT)
def test_anything_more_is_left_to_the_library(name: str) -> None:
    assert plain_pieces(LEFT[name], "ply", True) is None


def test_a_quad_among_the_triangles_is_left_to_the_library() -> None:
    data = bytearray(ply())
    data[-13] = 4  # the number of corners of the last triangle
    assert plain_pieces(bytes(data), "ply", True) is None


@pytest.mark.parametrize("name", ["a picture's places", "a picture's name"])
def test_a_picture_does_not_matter_where_none_is_wanted(name: str) -> None:
    assert plain_pieces(LEFT[name], "ply", False) is not None
