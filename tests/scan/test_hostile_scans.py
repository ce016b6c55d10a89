"""Every bad file is refused with one plain sentence, and nothing is opened, fetched or filled on the way."""

import base64
import io
import json
import os
import re
import stat
import struct
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.scan_files import as_bytes, picture, ply_text, textured_obj, tube, zipped
from helpers.subdivide import subdivided
from helpers.toy_rig import toy_rig

import breastrig.scan.read as read
import breastrig.scan.untrusted as untrusted
from breastrig.core.errors import BadInput, BadScan, BadSettings, TooLarge
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.pictures.companions import MISSING, NO_MATERIAL
from breastrig.scan.read import read_scan

FACES = toy_rig().faces


def sentence(error: BaseException) -> str:
    """The message, checked to be one sentence for a person."""
    text = str(error)
    assert "\n" not in text
    assert text.endswith(".")
    assert text[0].isupper() or text[0].isdigit() or text[0] == '"'
    assert len(text) < 300
    assert not re.search(r"Traceback|Error|0x|/tmp|numpy|trimesh", text)
    return text


def finer() -> bytes:
    """The tube as an OBJ of 1,536 triangles."""
    vertices, faces = subdivided(toy_rig().template, FACES)
    lines = ["v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in vertices]
    return "\n".join([*lines, *("f {} {} {}".format(*(face + 1)) for face in faces), ""]).encode()


def refused(data: bytes | Path, kind: type[BadInput] = BadScan, named: str | None = None, units: str = "auto") -> str:
    with pytest.raises(BadInput) as caught:
        read_scan(data, named, units)
    assert type(caught.value) is kind
    return sentence(caught.value)


def changed_glb(change: Callable[[dict[str, Any]], None], data: bytes | None = None) -> bytes:
    document, binary = split_glb(data or as_bytes(tube(), "glb"))
    change(document)
    return pack_glb(json.dumps(document).encode(), binary)


def test_an_empty_file() -> None:
    assert "empty" in refused(b"")


@pytest.mark.parametrize("named", ["ply", "obj", "stl", "glb", "zip"])
def test_a_text_file_with_the_ending_of_a_scan(named: str) -> None:
    assert f".{named}" in refused(b"Dear surgeon,\nthis is not a scan.\n", named=named)


def test_a_file_of_an_unknown_kind() -> None:
    assert "This file is no 3D scan that can be read" in refused(b"\x89HDF\r\n\x1a\n" + bytes(100))


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(BadScan, match="cannot be read"):
        read_scan(tmp_path / "nothing.ply")


def test_one_triangle() -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]])
    assert "only 1 triangle" in refused(ply_text(vertices, np.array([[0, 1, 2]])))


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_a_point_cloud(kind: str) -> None:
    points = toy_rig().template
    text = ply_text(points, np.zeros((0, 3), int))
    if kind == "obj":
        text = "\n".join("v {} {} {}".format(*point) for point in points).encode()
    assert "triangle mesh" in refused(text)


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e30", "-1e200"])
def test_many_vertices_that_are_not_finite(value: str) -> None:
    """Of a single one only its triangles are left out: test_mesh_variants.py."""
    vertices = toy_rig().template.copy()
    vertices[::9, 1] = float(value)
    assert "23 vertices of this scan are not finite" in refused(ply_text(vertices, FACES))
    with np.errstate(over="ignore"):
        stl = b"scan".ljust(80) + struct.pack("<I", len(FACES))
        corners = np.zeros((len(FACES), 50), np.uint8)
        corners[:, 12:48] = vertices[FACES].reshape(-1, 9).astype("<f4").view(np.uint8)
    assert "not finite" in refused(stl + corners.tobytes())


@pytest.mark.parametrize("kind", ["ply", "stl", "glb"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.99])
def test_a_truncated_file(kind: str, share: float) -> None:
    data = as_bytes(tube(), kind)
    assert "cut off" in refused(data[: int(share * len(data))], named=kind)


def test_triangles_that_name_missing_vertices() -> None:
    for wrong in (len(toy_rig().template), -1):
        faces = FACES.copy()
        faces[5, 1] = wrong
        refused(ply_text(toy_rig().template, faces))
    lines = ["v {} {} {}".format(*vertex) for vertex in toy_rig().template] + ["f 1 2 999999"] * 300
    refused("\n".join(lines).encode())


@pytest.mark.parametrize("count", [10**7, 10**12, 10**30])
def test_a_header_that_promises_more_than_the_file_holds(count: int) -> None:
    for element in (b"vertex 204", b"face 384"):
        name = element.split()[0]
        data = as_bytes(tube(), "ply").replace(element, b"%s %d" % (name, count), 1)
        with pytest.raises(BadInput) as caught:
            read_scan(data)
        sentence(caught.value)


def test_over_the_triangle_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, "TRIANGLES", 300)
    for kind in ("ply", "obj", "stl", "stl_ascii"):
        assert "triangles allowed" in refused(as_bytes(tube(), kind), TooLarge)


def test_a_glb_over_the_triangle_limit_by_repeating_one_mesh() -> None:
    def repeat(document: dict[str, Any]) -> None:
        index = next(node["mesh"] for node in document["nodes"] if "mesh" in node)
        document["nodes"] = [{"mesh": index} for _ in range(1500)]
        document["scenes"] = [{"nodes": list(range(1500))}]
        document["accessors"][document["meshes"][index]["primitives"][0]["indices"]]["count"] = 3 * 4000

    assert "triangles allowed" in refused(changed_glb(repeat), TooLarge)


def test_over_the_size_limit(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(untrusted, "FILE_BYTES", 1000)
    data = as_bytes(tube(), "ply")
    assert "MB allowed" in refused(data, TooLarge)
    (tmp_path / "scan.ply").write_bytes(data)
    assert "MB allowed" in refused(tmp_path / "scan.ply", TooLarge)


def test_a_glb_that_points_elsewhere() -> None:
    rig = toy_rig()
    painted = mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=picture())
    for uri in ("file:///etc/passwd", "../secret.bin", "https://example.org/a.bin"):
        assert "in another file" in refused(
            changed_glb(lambda d, uri=uri: d["buffers"].append({"byteLength": 4, "uri": uri}))
        )
        scan = read_scan(changed_glb(lambda d, uri=uri: d.update(images=[{"uri": uri}]), painted))
        assert scan.texture is None
        assert scan.notes == (MISSING,)


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_a_compressed_glb(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def pack(content: dict[str, Any]) -> Callable[[dict[str, Any]], None]:
        return lambda document: document["bufferViews"][0].update(extensions={name: content})

    whole = {"buffer": 0, "byteLength": 100, "byteStride": 12, "count": 204, "mode": "ATTRIBUTES"}
    for wrong in ({}, {"count": -1}, {"byteStride": 4000}, {"mode": "WORDS"}, {"byteOffset": 10**12}, {"count": 203}):
        refused(changed_glb(pack(whole | wrong)))
    assert "unpacks to more" in refused(changed_glb(pack(whole | {"count": 10**9})), TooLarge)
    monkeypatch.setitem(sys.modules, "meshopt", None)
    assert 'install "breastrig[formats]"' in refused(changed_glb(pack(whole)))


def test_a_glb_that_needs_an_unknown_extension() -> None:
    assert "extension" in refused(changed_glb(lambda d: d.update(extensionsRequired=["ABC_folded_meshes"])))


def test_a_gltf_whose_content_is_nonsense() -> None:
    for buffer in ("data:,", "data:base64,AAAA", "data:;base64,@@@@", "data:7", "data:" + "A" * 300, 5):
        document = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": buffer}], "meshes": []}
        refused(json.dumps(document).encode(), named="gltf")
    long = json.dumps({"asset": {"version": "2.0"}, "names": ["x" * 100] * 200_000}).encode()
    assert "MB of text" in refused(long, TooLarge)


def test_a_scene_that_contains_itself() -> None:
    refused(changed_glb(lambda d: d.update(nodes=[{"children": [1]}, {"children": [0]}], scenes=[{"nodes": [0]}])))
    refused(changed_glb(lambda d: d.update(nodes=[{"children": [0]}], scenes=[{"nodes": [0]}])))


def test_a_glb_whose_arrays_claim_to_be_huge() -> None:
    def grow(document: dict[str, Any]) -> None:
        for accessor in document["accessors"]:
            accessor["count"] = 10**11
            accessor.pop("bufferView", None)

    assert "triangles allowed" in refused(changed_glb(grow), TooLarge)
    refused(changed_glb(lambda d: d["accessors"][0].update(count=-3)))
    refused(changed_glb(lambda d: d["accessors"][0].update(count="many")))


@pytest.mark.parametrize(
    "text",
    [b"{", b"[]", b"null", b'{"meshes": 3}', b'{"nodes": [3]}', b"[" * 100_000, b'{"accessors": {}}', b"\xff\xfe"],
)
def test_a_glb_whose_json_is_nonsense(text: bytes) -> None:
    refused(pack_glb(text, b""))


def test_a_glb_of_another_version() -> None:
    data = bytearray(as_bytes(tube(), "glb"))
    data[4] = 1
    assert "version 1" in refused(bytes(data))


def bomb() -> bytes:
    """A PNG of a few bytes that claims 100,000 x 100,000 pixels."""
    data = picture("PNG")
    return data[:16] + struct.pack(">II", 100_000, 100_000) + data[24:]


def test_a_picture_with_too_many_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    import breastrig.scan.pictures.texture as texture

    large = picture("PNG", (400, 300))
    monkeypatch.setattr(texture, "IMAGE_PIXELS", 100_000)
    rig = toy_rig()
    assert "pixels" in refused(zipped({**textured_obj("a.png"), "a.png": large}), TooLarge)
    assert "pixels" in refused(mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=large), TooLarge)


def test_a_picture_bomb_is_never_unpacked() -> None:
    rig = toy_rig()
    for data in (
        zipped({**textured_obj("a.png"), "a.png": bomb()}),
        mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=bomb()),
    ):
        try:
            assert read_scan(data).texture is None
        except BadInput as error:
            sentence(error)


def test_a_damaged_picture_is_left_out_and_said() -> None:
    rig = toy_rig()
    damaged = picture()[:300]
    for data in (
        zipped({**textured_obj("a.jpg"), "a.jpg": damaged}),
        mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=damaged),
    ):
        scan = read_scan(data)
        assert scan.texture is None
        assert scan.uv is None
        assert "left out" in scan.notes[0]


def test_a_picture_hidden_in_a_data_address_is_checked_too() -> None:
    uri = "data:image/png;base64," + base64.b64encode(b"GIF89a" + bytes(60)).decode()
    rig = toy_rig()
    painted = mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=picture())
    scan = read_scan(changed_glb(lambda d: d.update(images=[{"uri": uri}]), painted))
    assert scan.texture is None
    assert "left out" in scan.notes[0]


@pytest.mark.parametrize(
    ("files", "word"),
    [
        ({}, "no mesh"),
        ({"notes.txt": b"x", "inner.zip": b"y"}, "no mesh"),
        ({"standing.ply": b"x", "supine.ply": b"y"}, "2 scans"),
        ({"standing/model.obj": b"x", "supine/model.obj": b"y"}, "2 scans"),
        ({"../a.ply": b"x"}, "lead out"),
        ({"C:\\a.ply": b"x"}, "lead out"),
        ({"a.ply": b"x", "A.PLY": b"y"}, "same name"),
        ({"a.ply": b""}, "empty"),
    ],
)
def test_a_zip_with_the_wrong_things_in_it(files: dict[str, bytes], word: str) -> None:
    assert word in refused(zipped(files))


def test_a_zip_with_too_much_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    import breastrig.scan.formats.archive as archive

    assert "files" in refused(zipped({f"{i}.jpg": b"" for i in range(2001)}), TooLarge)
    assert "times" in refused(zipped({"a.obj": bytes(2_000_000)}), TooLarge)
    monkeypatch.setattr(archive, "FILE_BYTES", 1000)
    assert "unpacks" in refused(zipped({"a.ply": as_bytes(tube(), "ply")}), TooLarge)


def test_a_damaged_zip() -> None:
    data = zipped({"a.ply": as_bytes(tube(), "ply")})
    assert "cut off" in refused(data[: len(data) // 2])
    wrong = bytearray(data)
    wrong[200] ^= 0xFF
    refused(bytes(wrong))


def test_a_zip_that_lies_about_its_sizes() -> None:
    data = bytearray(zipped({"a.obj": b"v 0 0 0\n" * 1000}))
    for mark, place in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        start = data.find(mark) + place
        data[start : start + 4] = struct.pack("<I", 100)
    refused(bytes(data))


def test_an_encrypted_zip(tmp_path: Path) -> None:
    data = bytearray(zipped({"a.ply": as_bytes(tube(), "ply")}))
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.find(mark) + place] |= 1
    assert "encrypted" in refused(bytes(data))


def test_a_zip_of_a_zip_under_another_name() -> None:
    inner = zipped({"a.ply": as_bytes(tube(), "ply")})
    assert "another zip" in refused(zipped({"a.ply": inner}))


@pytest.mark.parametrize("scale", [0.05, 1e4, 1e6, 1e-30])
def test_a_scan_of_no_plausible_size(scale: float) -> None:
    assert "no torso" in refused(as_bytes(tube(scale), "ply"))


def test_a_scan_in_the_wrong_unit() -> None:
    text = refused(as_bytes(tube(1000.0), "ply"), units="m")
    assert "In metres" in text
    assert "mm would fit" in text


def test_a_scan_of_a_single_place() -> None:
    refused(ply_text(np.zeros_like(toy_rig().template), FACES))
    refused(ply_text(np.zeros_like(toy_rig().template), FACES), units="m")


def test_coordinates_too_large_for_arithmetic() -> None:
    refused(ply_text(toy_rig().template * 1e300, FACES))


def test_an_ascii_stl_with_a_number_beyond_single_precision() -> None:
    text = as_bytes(tube(), "stl_ascii").replace(b"vertex 0", b"vertex 1e300", 1)
    assert b"1e300" in text
    refused(text)


@pytest.mark.parametrize("unit", ["auto", "m"])
def test_an_ascii_stl_with_many_numbers_whose_squares_are_too_large(unit: str) -> None:
    """So many that they are no strays: the size of the scan is asked for."""
    text = re.sub(rb"vertex 0\S*", b"vertex 1e160", as_bytes(tube(), "stl_ascii"))
    assert text.count(b"1e160") > 100
    assert "not finite" in refused(text, units=unit)


def test_an_unknown_unit() -> None:
    assert "furlong" in refused(as_bytes(tube(), "ply"), BadSettings, units="furlong")


def test_no_mesh_names_a_file_in_the_zip_that_is_no_companion() -> None:
    files = textured_obj("model.obj")
    assert read_scan(zipped(files)).texture is None


def test_zipfile_is_asked_for_nothing_before_the_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> bytes:
        raise AssertionError("an entry was unpacked before the archive was checked")

    data = zipped({f"{i}.jpg": b"" for i in range(2001)})
    monkeypatch.setattr(zipfile.ZipFile, "read", never)
    refused(data, TooLarge)


def zip_of(entries: list[tuple[zipfile.ZipInfo | str, bytes]], packing: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", packing) as archive:
        for entry, content in entries:
            archive.writestr(entry, content, packing)
    return stream.getvalue()


def link(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    return entry


def test_links_in_a_zip_lead_nowhere(tmp_path: Path) -> None:
    (tmp_path / "secret.jpg").write_bytes(picture())
    target = str(tmp_path / "secret.jpg").encode()
    files = [*textured_obj().items(), (link("skin.jpg"), target)]
    scan = read_scan(zip_of(files))
    assert scan.texture is None
    assert "left out" in scan.notes[0]
    assert "holds no OBJ data" in refused(zip_of([(link("scan.obj"), b"/etc/passwd")]))


@pytest.mark.parametrize(
    "name", ["/etc/scan.ply", "//scan.ply", "..\\scan.ply", "a/../../scan.ply", "C:scan.ply", ".ply"]
)
def test_a_zip_with_names_that_lead_elsewhere(name: str) -> None:
    refused(zip_of([(name, as_bytes(tube(), "ply"))]))


@pytest.mark.parametrize("packing", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_zip_that_is_packed_so_that_no_limit_holds(packing: int) -> None:
    assert "ordinary zip" in refused(zip_of([("scan.ply", as_bytes(tube(), "ply"))], packing))


def test_a_zip_with_a_list_of_entries_that_takes_long_to_read(monkeypatch: pytest.MonkeyPatch) -> None:
    data = zip_of([(f"{index}.jpg", b"") for index in range(41_000)])
    monkeypatch.setattr(zipfile, "ZipFile", None)  # which reads the whole list before it can be counted
    assert "far more than the 10,000 files" in refused(data, TooLarge)


def test_a_zip_whose_list_is_announced_in_the_record_for_huge_ones() -> None:
    data = zip_of([("scan.ply", as_bytes(tube(), "ply"))])
    end = data.rindex(b"PK\x05\x06")
    locator = b"PK\x06\x07" + struct.pack("<IQI", 0, 0, 1)
    assert "far more than" in refused(data[:end] + locator + data[end:], TooLarge)


def test_materials_that_make_a_reader_open_a_picture_again_and_again() -> None:
    files = {**textured_obj(), "skin.jpg": picture()}
    one, noise = b"newmtl a\nmap_Kd skin.jpg\n", np.random.default_rng(1).bytes(2**19).hex().encode()
    for material in (300 * one, b"newmtl a\n" + 300 * b"map_Kd skin.jpg\n", one + noise):
        assert "MTL file" in refused(zipped({**files, "model.mtl": material}), TooLarge)


@pytest.mark.parametrize(
    "name",
    ["../../etc/passwd", "/etc/passwd", "C:\\secret.jpg", "x" * 100_000, "https://example.org/a.jpg", "\x00", "."],
)
def test_a_material_that_names_something_elsewhere_gets_nothing_and_it_is_said(name: str) -> None:
    scan = read_scan(zipped(textured_obj(name)))
    assert scan.texture is None
    assert scan.notes == (MISSING,)


def test_an_obj_of_more_materials_than_meshes_can_be_made_of() -> None:
    groups = b"".join(b"usemtl m%d\nf %d %d %d\n" % (index, *(FACES[index] + 1)) for index in range(300))
    assert "256 materials" in refused(finer() + groups, TooLarge)
    again = b"".join(b"usemtl m%d\nf %d %d %d\n" % (index % 9, *(FACES[index] + 1)) for index in range(300))
    assert len(read_scan(finer() + again).faces) == 1536 + 300


def test_polygons_with_thousands_of_corners() -> None:
    polygon = b"f " + b" ".join(b"%d" % (index % 200 + 1) for index in range(20_000)) + b"\n"
    assert "polygons with hundreds of corners" in refused(finer() + polygon)


def test_an_stl_of_many_parts() -> None:
    triangle = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    assert "256 parts" in refused((b"solid a\n" + triangle + b"endsolid a\n") * 300, TooLarge)


HEADER = "ply\nformat ascii 1.0\nelement vertex 204\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    "lines",
    [
        "element face 1000000000000000000000\nproperty list uchar int vertex_indices",
        "element face -5\nproperty list uchar int vertex_indices",
        "element face 1_0\nproperty list uchar int vertex_indices",
        "element face 384\nproperty list float int vertex_indices",
        "element face 384\nproperty list uchar words vertex_indices",
        "element face 384\nproperty list uchar int",
        "element face 384\nproperty",
        "element face\nproperty list uchar int vertex_indices",
        "element vertex 300\nproperty list uchar int vertex_indices",
        "element face 384\n" + "property int p\n" * 20_000 + "property list uchar int vertex_indices",
        "element per-son 1000000000\nproperty float a\nelement face 384\nproperty list uchar int vertex_indices",
        "format binary 1.0\nelement face 384\nproperty list uchar int vertex_indices",
    ],
    ids=lambda lines: lines[:40],
)
def test_a_ply_header_that_makes_no_sense(lines: str) -> None:
    body = ply_text(toy_rig().template, FACES).split(b"end_header\n", 1)[1]
    with pytest.raises(BadInput) as caught:
        read_scan(HEADER.encode() + lines.encode() + b"\nend_header\n" + body)
    sentence(caught.value)


def test_a_billion_vertices_in_two_hundred_bytes() -> None:
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        text = HEADER.replace("ascii", form).replace("204", "1000000000") + "end_header\n" + "0 0 0\n" * 10
        assert "points allowed" in refused(text.encode(), TooLarge)


def test_a_point_that_lies_kilometres_away() -> None:
    vertices, faces = subdivided(toy_rig().template, FACES)
    vertices[17] = [0.0, 5e4, 0.0]
    assert "One vertex of this scan lies more than 1 km" in refused(ply_text(vertices, faces))
    assert "One vertex of this scan lies more than 1 km" in refused(ply_text(1000.0 * vertices, faces))
    vertices[40:42] = 1e25
    assert "3 vertices of this scan lie more than 1 km" in refused(ply_text(vertices, faces))


def test_a_loose_point_that_lies_kilometres_away_is_left_out_and_said() -> None:
    vertices = np.concatenate([toy_rig().template, [[0.0, 5e4, 0.0]]])
    colours = np.random.default_rng(3).integers(0, 256, (len(vertices), 3))
    rows = [" ".join(map(str, [*place, *colour])) for place, colour in zip(vertices, colours, strict=True)]
    rows += [" ".join(map(str, [3, *face])) for face in FACES]
    more = b"".join(b"property uchar %s\n" % name for name in (b"red", b"green", b"blue"))
    header = ply_text(vertices, FACES).split(b"end_header")[0].replace(b"element face", more + b"element face")
    scan = read_scan(header + b"end_header\n" + "\n".join([*rows, ""]).encode())
    np.testing.assert_allclose(scan.vertices, toy_rig().template, atol=1e-6)
    np.testing.assert_array_equal(scan.faces, FACES)
    assert scan.colours is not None
    np.testing.assert_array_equal(scan.colours, colours[:-1])
    assert scan.notes == ("Points far away that no triangle uses were left out.",)


def test_a_scan_that_is_too_far_from_its_origin_for_numbers() -> None:
    assert "move it to the origin" in refused(ply_text(toy_rig().template + 3e7, FACES).replace(b"float", b"double"))


def test_what_is_no_ordinary_file_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scan.ply")
    (tmp_path / "folder.ply").mkdir()
    for path in (tmp_path / "scan.ply", Path("/dev/zero")):
        assert "no ordinary file" in refused(path)
    assert "folder holds no DICOM files" in refused(tmp_path / "folder.ply")


def test_a_name_of_thousands_of_letters_is_not_repeated(tmp_path: Path) -> None:
    for name in ("x" * 5000, "x" * 5000 + ".ply", "a\0b"):
        with pytest.raises(BadScan, match="cannot be read"):
            read_scan(tmp_path / name)
        try:
            read_scan(tmp_path / name)
        except BadScan as error:
            sentence(error)


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_the_librarys_log_says_nothing_of_a_file(kind: str, caplog: pytest.LogCaptureFixture) -> None:
    data = b"mtllib Mustermann.mtl\nusemtl a\n" + finer()
    if kind == "ply":
        data = ply_text(toy_rig().template, FACES).replace(
            b"element v", b"comment TextureFile Mustermann.png\nelement v"
        )
    with caplog.at_level(0):
        scan = read_scan(data)
        refused(data[: len(data) // 2])
    assert not caplog.records
    assert scan.notes == (MISSING if kind == "ply" else NO_MATERIAL,)
    assert not read_scan(data, texture=False).notes
