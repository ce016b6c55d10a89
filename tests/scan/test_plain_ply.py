"""The quick way to read a plain PLY finds what the library finds, and leaves to it whatever is not plain."""

import numpy as np
import pytest
import trimesh
from helpers.scan_files import as_bytes, tube

from breastrig.scan.formats import plain_ply as quick
from breastrig.scan.formats.plain_ply import plain_ply
from breastrig.scan.formats.ply_obj_stl import mesh_pieces
from breastrig.scan.read import read_scan


def coloured(alpha: bool) -> trimesh.Trimesh:
    mesh = tube()
    colours = np.random.default_rng(3).integers(0, 256, (len(mesh.vertices), 4 if alpha else 3)).astype(np.uint8)
    mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=colours)
    return mesh


def rewritten(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new, 1)


def big_endian(data: bytes) -> bytes:
    """A file of float32 places and uchar, int32 triangles."""
    mesh = trimesh.load(trimesh.util.wrap_as_stream(data), file_type="ply", process=False)
    head = data[: data.index(b"end_header\n") + 11].replace(b"binary_little_endian", b"binary_big_endian")
    rows = np.zeros(len(mesh.faces), [("n", ">u1"), ("v", ">i4", 3)])
    rows["n"], rows["v"] = 3, mesh.faces
    return head + mesh.vertices.astype(">f4").tobytes() + rows.tobytes()


@pytest.mark.parametrize(
    "data",
    [
        as_bytes(tube(), "ply"),
        as_bytes(coloured(alpha=False), "ply"),
        as_bytes(coloured(alpha=True), "ply"),
        big_endian(as_bytes(tube(), "ply")),
        rewritten(as_bytes(tube(), "ply"), b"list uchar int", b"list uint8 uint32"),
    ],
    ids=["plain", "colours", "colours and alpha", "big-endian", "other names of types"],
)
def test_it_is_what_the_library_reads(data: bytes) -> None:
    (found,) = plain_ply(data).pieces
    (expected,) = mesh_pieces(data, "ply", {}, True).pieces
    np.testing.assert_array_equal(found.vertices, expected.vertices)
    np.testing.assert_array_equal(found.faces, expected.faces)
    assert (found.vertices.dtype, found.faces.dtype) == (np.float64, np.int64)
    assert (found.colours is None) == (expected.colours is None)
    if found.colours is not None:
        np.testing.assert_array_equal(found.colours, expected.colours)


def left_to_the_library() -> dict[str, bytes]:
    data, head = as_bytes(tube(), "ply"), b"element vertex"
    end = data.index(b"end_header")
    return {
        "cut off": data[:-1],
        "longer": data + b"\0",
        "text": data.replace(b"binary_little_endian", b"ascii", 1),
        "a picture": rewritten(data, head, b"comment TextureFile skin.png\n" + head),
        "another element": data[:end] + b"element edge 0\nproperty int a\n" + data[end:],
        "texture coordinates": rewritten(data, b"property float z", b"property float z\nproperty float s"),
        "a quad": data[:-13] + b"\x04" + data[-12:],
        "a wrong corner": data[:-4] + np.int32(10**6).tobytes(),
        "a negative corner": data[:-4] + np.int32(-1).tobytes(),
        "corners that are not whole": rewritten(data, b"list uchar int", b"list uchar float"),
        "a property twice": rewritten(data, b"property float z", b"property float y"),
        "no end of the header": data[: end - 1],
        "no vertices": rewritten(data, b"element vertex 204", b"element vertex 0"),
    }


@pytest.mark.parametrize("kind", left_to_the_library())
def test_what_is_not_plain_is_left_to_the_library(kind: str) -> None:
    assert plain_ply(left_to_the_library()[kind]) is None


def test_scans_are_read_by_it(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr("breastrig.scan.read.plain_ply", lambda data: asked.append(quick.plain_ply(data)) or asked[-1])
    assert len(read_scan(as_bytes(tube(), "ply")).faces) == 384
    assert asked[0] is not None
