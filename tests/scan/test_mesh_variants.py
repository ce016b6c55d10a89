"""One body in every form that programs are known to write: the same triangles, size and colours, or a true sentence."""

import json
import re
import unicodedata
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import meshopt
import numpy as np
import pytest
from helpers.mesh_variants import (
    BASE,
    FACES,
    JPEG,
    OF_FACES,
    OF_VERTICES,
    UV,
    UV_FLIPPED,
    VERTICES,
    colour,
    embedded,
    glb,
    gltf,
    linear,
    obj,
    painted_obj,
    pixels,
    ply,
    quads,
    saved,
    stl,
    stl_text,
    vertex_colours,
)
from helpers.scan_files import zipped
from helpers.usd_scan import usda, usdz
from PIL import Image
from scipy.spatial import cKDTree

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats.gltf import glb as glb_module
from breastrig.scan.formats.stl import WRONG_COUNT
from breastrig.scan.pictures import companions, tiles
from breastrig.scan.pictures.joined_textures import UNPAINTED
from breastrig.scan.pictures.texture import LEFT_OUT, pixels_of
from breastrig.scan.piece import PARTLY_COLOURED
from breastrig.scan.point_clouds.point_table import table_points
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

MTL = "newmtl skin\nKd 1 1 1\n"
CENTRES = VERTICES[FACES].mean(axis=1)
TRUE = colour(UV[FACES].mean(axis=1))


def shown_colours(scan: Scan) -> np.ndarray | None:
    """(F, 3) in the middle of each triangle."""
    if scan.picture is not None and scan.uv is not None:
        picture = pixels_of(scan.picture).astype(float)
        u, v = scan.uv[scan.faces].mean(axis=1).T
        height, width = picture.shape[:2]
        down, across = (1.0 - v) * height, u * width
        return picture[np.clip(down, 0, height - 1).astype(int), np.clip(across, 0, width - 1).astype(int)]
    return None if scan.colours is None else scan.colours[scan.faces].mean(axis=1)


def assert_same_body(scan: Scan, coloured: bool = True, grey: bool = False) -> None:
    assert len(scan.faces) == len(FACES)
    far, which = cKDTree(CENTRES).query(scan.vertices[scan.faces].mean(axis=1))
    assert far.max() < 2e-5
    found = shown_colours(scan)
    assert (found is not None) == coloured
    if found is not None:
        wanted = TRUE[which]
        if grey:
            wanted = np.repeat(wanted @ [[0.299], [0.587], [0.114]], 3, axis=1)
        assert np.abs(found - wanted).mean() < 3.0


UNEVEN = [[0.5] * (k % 3) for k in range(len(FACES))]
SHARES, WHOLE = OF_VERTICES / 255.0, OF_VERTICES
UV_COLUMNS = {
    name: {a: ("float", UV[:, 0]), b: ("float", UV[:, 1])}
    for name, a, b in (
        ("s t", "s", "t"),
        ("u v", "u", "v"),
        ("texture_u", "texture_u", "texture_v"),
        ("tu", "tu", "tv"),
        ("texture_s", "texture_s", "texture_t"),
        ("texcoord_u", "texcoord_u", "texcoord_v"),
        ("uv0", "u0", "v0"),
    )
}
STRIP = [k for face in FACES for k in (*face.tolist(), -1)]


def with_strips(form: str) -> bytes:
    """The triangles as strips, each ended by -1."""
    text = ply(vertex_colours("uchar", WHOLE), form=form)
    head, body = text.split(b"end_header\n", 1)
    order = "<" if form == "binary_little_endian" else ">"
    rows = len(VERTICES) * 15
    strips = np.array(len(STRIP), order + "i4").tobytes() + np.array(STRIP, order + "i4").tobytes()
    head = head[: head.index(b"element face")] + b"element tristrips 1\nproperty list int int vertex_indices\n"
    return head + b"end_header\n" + body[:rows] + strips


PLY = {
    **{f"quads, {form}": ply(vertex_colours("uchar", WHOLE), form=form, polygons=quads()) for form in (
        "ascii", "binary_little_endian", "binary_big_endian",
    )},
    "quads with a list before": ply(
        vertex_colours("uchar", WHOLE), {"weights": ("list uchar float", UNEVEN)},
        polygons=quads(), before=True,
    ),
    "floats to 255": ply(vertex_colours("float", WHOLE)),
    "floats to 1": ply(vertex_colours("double", SHARES)),
    "floats to 255 in text": ply(vertex_colours("float", WHOLE), form="ascii"),
    "shares in text that says uchar": ply(vertex_colours("uchar", SHARES), form="ascii"),
    "16 bits": ply(vertex_colours("ushort", WHOLE.astype(int) * 257)),
    "bytes as long numbers": ply(vertex_colours("int", WHOLE.astype(int))),
    "bytes as 16 bits": ply(vertex_colours("ushort", WHOLE.astype(int))),
    "diffuse": ply(vertex_colours("uchar", WHOLE, "diffuse_red diffuse_green diffuse_blue")),
    "a prefix": ply(vertex_colours("uchar", WHOLE, "color_red color_green color_blue")),
    "the skin's own before others": ply(
        vertex_colours("uchar", 0 * WHOLE, "specular_red specular_green specular_blue") | vertex_colours("uchar", WHOLE)
    ),
    "capitals": ply(vertex_colours("uchar", WHOLE, "Red Green Blue")),
    "colours of faces": ply(face=vertex_colours("uchar", OF_FACES)),
    "colours of quads before corners": ply(face=vertex_colours("uchar", OF_FACES), before=True),
    "corners by the other name": ply(vertex_colours("uchar", WHOLE), corners="list uchar uint vertex_index"),
    "corners by an unknown name": ply(vertex_colours("uchar", WHOLE), corners="list int uint corners"),
    "lists of vertices": ply({"weights": ("list uchar float", [[0.1] * (k % 2) for k in range(len(VERTICES))]),
                              **vertex_colours("uchar", WHOLE)}),
    "strips": with_strips("binary_little_endian"),
    "strips of the other order": with_strips("binary_big_endian"),
    **{f"places called {name}": zipped({"a.ply": ply(columns, head="comment TextureFile skin.jpg"), "skin.jpg": JPEG})
       for name, columns in UV_COLUMNS.items()},
    "places of corners": zipped({"a.ply": ply(
        face={"texcoord": ("list uchar float", UV[FACES].reshape(-1, 6))}, head="comment TextureFile skin.jpg",
    ), "skin.jpg": JPEG}),
    "places of corners in text": zipped({"a.ply": ply(
        face={"texcoord": ("list uchar float", UV[FACES].reshape(-1, 6))}, form="ascii",
        head="comment TextureFile skin.jpg",
    ), "skin.jpg": JPEG}),
    "two pictures": zipped({"a.ply": ply(
        UV_COLUMNS["s t"], {"texnumber": ("int", np.arange(len(FACES)) % 2)},
        head="comment TextureFile one.jpg\ncomment TextureFile other.png",
    ), "one.jpg": JPEG, "other.png": saved("PNG")}),
}  # fmt: skip


@pytest.mark.parametrize("name", PLY)
def test_a_ply_is_read_with_its_colours(name: str) -> None:
    scan = read_scan(PLY[name])
    assert_same_body(scan)
    assert scan.notes == ()


NO_NUMBERS = ["nan", "-nan(ind)", "nan(snan)", "-1.#IND00", "1.#QNAN", "1.#INF00", "-1.#J", "1,#IND", "inf", "-1.#IND"]


@pytest.mark.parametrize("word", NO_NUMBERS)
def test_words_for_no_number_cost_what_uses_them_only(word: str) -> None:
    unused = f"v {word} {word} {word}\n".encode()
    assert_same_body(read_scan(obj("", False) + unused), coloured=False)
    place = f"vt {word} {word}".encode()
    mesh = re.sub(rb"(?m)^vt .*$", place, obj("mtllib a.mtl"), count=1)
    data = zipped({"a.obj": mesh, "a.mtl": f"{MTL}map_Kd a.jpg".encode(), "a.jpg": JPEG})
    scan = read_scan(data)
    assert len(scan.faces) == len(FACES)
    assert scan.notes == (UNPAINTED,)
    head, body = ply(form="ascii").split(b"end_header\n")
    used = head + b"end_header\n" + re.sub(rb"^\S+", word.encode(), body)
    assert len(read_scan(used).faces) == len(FACES) - int((FACES == 0).any(axis=1).sum())


def test_points_where_a_camera_saw_nothing_are_no_sign_of_a_cut_file() -> None:
    unused = b"v -1.#IND00 -1.#IND00 -1.#IND00\n" * len(VERTICES)
    assert_same_body(read_scan(unused + obj("", False, corner="{1}").rstrip()), coloured=False)


def test_a_table_of_points_may_begin_with_what_is_no_number() -> None:
    rows = ["-1.#IND -1.#IND -1.#IND"] * 20 + [f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in VERTICES]
    assert len(table_points("\n".join(rows).encode()).points) == 20 + len(VERTICES)


REMARKED: dict[str, Callable[[str], str]] = {
    "behind": lambda line: f"{line} # first, of 3.5",
    "without a blank": lambda line: f"{line}#first",
    "behind a tab": lambda line: f"{line}\t# C:\\scans\\",
    "goes on": lambda line: " \\\n".join(line.rsplit(" ", 2)),
    "goes on behind a blank": lambda line: " \\ \r\n\t".join(line.rsplit(" ", 2)),
    "a folder before it": lambda line: f"# C:\\scans\\\n{line}",
}


@pytest.mark.parametrize("name", REMARKED)
def test_remarks_in_an_obj_and_lines_that_go_on(name: str) -> None:
    lines = obj("", False).decode().splitlines()
    rows = [REMARKED[name](line) if line[:2] in ("v ", "f ") else line for line in lines]
    scan = read_scan("\n".join(rows).encode() + b"\n")
    assert_same_body(scan, coloured=False)
    np.testing.assert_array_equal(scan.faces, FACES)
    assert scan.notes == ()


def test_names_of_materials_may_have_a_remark_behind_them_or_in_them() -> None:
    files = {"scan.jpg": JPEG, "b.jpg": saved("JPEG", Image.new("RGB", (8, 8)))}
    remarked = painted_obj("newmtl skin # of the body\nmap_Kd scan.jpg\nnewmtl other\nmap_Kd b.jpg\n", files)
    assert_same_body(read_scan(remarked))
    mesh = obj("mtllib scan.mtl # colours").replace(b"usemtl skin", b"usemtl skin # 1")
    named = "newmtl skin # 2\nmap_Kd b.jpg\nnewmtl skin # 1\nmap_Kd scan.jpg\n"
    assert_same_body(read_scan(zipped({"a.obj": mesh, "scan.mtl": named.encode(), **files})))


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("corners", [[], [5], [5, 6]])
@pytest.mark.parametrize("at", [0, 100, len(FACES)])
def test_faces_of_a_ply_with_too_few_corners_are_left_out_and_said(form: str, corners: list[int], at: int) -> None:
    polygons = FACES.tolist()
    polygons[at:at] = [corners]
    colours = np.insert(OF_FACES, at, [255, 0, 255], axis=0)
    scan = read_scan(ply(face=vertex_colours("uchar", colours), form=form, polygons=polygons))
    assert_same_body(scan)
    assert scan.notes == ("One face of this file has fewer than three corners and was left out.",)


def test_faces_of_an_obj_with_too_few_corners_are_left_out_and_said() -> None:
    scan = read_scan(obj("", False).replace(b"usemtl skin", b"f 1 2\nf 3\nf"))
    assert_same_body(scan, coloured=False)
    assert scan.notes == ("3 faces of this file have fewer than three corners and were left out.",)


@pytest.mark.parametrize("data", [obj(uv=False, head=""), ply(form="ascii"), stl_text()], ids=["obj", "ply", "stl"])
def test_decimal_commas_are_decimals(data: bytes) -> None:
    lines = [line.replace(b".", b",") if line[:1] in b"v-0123456789 " else line for line in data.splitlines()]
    data = b"\n".join([*lines, b""])
    assert data.count(b",") > 500
    assert_same_body(read_scan(data, "stl" if data.startswith(b"solid") else None), coloured=False)


def painted(options: str = "", name: str = "scan.jpg", file: str | None = None, word: str = "map_Kd") -> bytes:
    return painted_obj(f"{MTL}{word} {options}{name}\n", {file or name: JPEG})


NFC, NFD = (unicodedata.normalize(form, "Büste.jpg") for form in ("NFC", "NFD"))
OBJ = {
    "clamp, scale, offset": painted("-clamp on -s 1 1 1 -o 0 0 0 "),
    "blend, boost, channel": painted("-blendu on -blendv off -boost 1.0 -cc off -texres 512 "),
    "mm, bm, imfchan": painted("-mm 0 1 -bm 0.5 -imfchan l "),
    "short options": painted("-s 1 1 -o 0 "),
    "quotes": painted(name='"scan.jpg"', file="scan.jpg"),
    "%20": painted(name="my%20scan.jpg", file="my scan.jpg"),
    "spaces": painted(name="my scan (1)  b.jpg"),
    "spaces after options": painted("-clamp on ", name="2 my scan.jpg"),
    "back slashes": painted(name="C:\\scans\\anna\\scan.jpg", file="scan.jpg"),
    "a folder": painted(name="textures/scan.jpg"),
    "a folder of another computer": painted(name="/scans/anna/scan.jpg", file="pictures/scan.jpg"),
    "other case": painted(name="Scan.JPG", file="scan.jpg"),
    "composed accents": painted(name=NFC, file=NFD),
    "decomposed accents": painted(name=NFD, file=NFC),
    "map_Ka": painted(word="map_Ka"),
    "map_Ke": painted(word="map_Ke"),
    "MAP_KD": painted(word="MAP_KD"),
    "a tab": painted_obj(f"{MTL}\tmap_Kd\tscan.jpg\n", {"scan.jpg": JPEG}),
    "material with spaces": painted_obj(f"{MTL}map_Kd scan.jpg\n", {"scan.jpg": JPEG}, "my scan 2.mtl"),
    "material in quotes": painted_obj(f"{MTL}map_Kd scan.jpg\n", {"scan.jpg": JPEG}, "a.mtl", 'mtllib "./a.mtl"'),
    "several materials": painted_obj(
        f"{MTL}map_Kd scan.jpg\n", {"scan.jpg": JPEG, "b.mtl": b"newmtl other\n"}, "a.mtl", "mtllib b.mtl a.mtl"
    ),
    "two lines of materials": painted_obj(
        f"{MTL}map_Kd scan.jpg\n", {"scan.jpg": JPEG, "b.mtl": b"newmtl other\n"}, "a.mtl", "mtllib b.mtl\nmtllib a.mtl"
    ),
    "negative corners": zipped({
        "a.obj": obj("mtllib a.mtl", corner="{1}/{1}"), "a.mtl": f"{MTL}map_Kd scan.jpg".encode(), "scan.jpg": JPEG,
    }),
    "normals": zipped({
        "a.obj": b"vn 0 0 1\n" + obj("mtllib a.mtl", corner="{0}/{0}/1"),
        "a.mtl": f"{MTL}map_Kd a.jpg".encode(), "a.jpg": JPEG,
    }),
    "colours to 1": obj("", False, SHARES),
    "colours of ZBrush": obj("", False) + b"".join(b"#MRGB ff%02x%02x%02x\n" % tuple(row) for row in WHOLE.tolist()),
    "a remark behind the name": painted_obj(f"{MTL}map_Kd scan.jpg # the skin\n", {"scan.jpg": JPEG}),
    "colours to 255": obj("", False, WHOLE),
    "colours with opacity": obj("", False, np.column_stack([SHARES, np.ones(len(SHARES))])),
    "colours and places without a picture": obj("", True, SHARES),
}  # fmt: skip


@pytest.mark.parametrize("name", OBJ)
def test_an_obj_is_read_with_its_colours(name: str) -> None:
    scan = read_scan(OBJ[name])
    assert_same_body(scan)
    assert scan.notes == ()


ACROSS = np.floor(2.999 * UV[FACES].mean(axis=1)[:, 0])  # of each triangle: the tile that paints it


def tiled_places(spread: float = 1.0) -> np.ndarray:
    """(F, 3, 2): three tiles, the last one row up; each has a third of the triangles."""
    return np.asarray(UV[FACES] + spread * np.stack([ACROSS, ACROSS // 2], axis=1)[:, None])


def tiled_obj(spread: float = 1.0) -> bytes:
    lines = ["mtllib scan.mtl", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in VERTICES)]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in tiled_places(spread).reshape(-1, 2)]
    faces = [" ".join(f"{v + 1}/{3 * k + c + 1}" for c, v in enumerate(face)) for k, face in enumerate(FACES)]
    return "\n".join([*lines, "usemtl skin", *(f"f {face}" for face in faces), ""]).encode()


def tile_pictures(*names: str) -> dict[str, bytes]:
    """Each with the colours that its triangles have, and others where only those of other tiles lie."""
    found = {}
    for tile, name in enumerate(names):
        shown = pixels(192)
        shown[:, np.abs((np.arange(192) + 0.5) / 64 - tile - 0.5) > 0.7] = [0, 0, 0] if tile else [255, 0, 255]
        found[name] = saved("PNG", Image.fromarray(shown))
    return found


UDIM = ("s.1001.png", "s.1002.png", "s.1013.png")
TILES = {
    "udim": ("s.<UDIM>.png", UDIM),
    "udim in small letters": ("maps/s.<udim>.png", UDIM),
    "the first is named": ("s.1001.png", UDIM),
    "another is named": ("s.1002.png", UDIM),
    "with options": ("-clamp on s 2001 1001.png", ("s 2001 1001.png", "s 2001 1002.png", "s 2001 1013.png")),
    "Mudbox": ("s_u1_v1.png", ("s_u1_v1.png", "s_u2_v1.png", "s_u3_v2.png")),
    "ZBrush": ("s_u0_v0.png", ("s_u0_v0.png", "s_u1_v0.png", "s_u2_v1.png")),
    "uvtile": ("s_<UVTILE>.png", ("s_u1_v1.png", "s_u2_v1.png", "s_u3_v2.png")),
    "uvtile from nought": ("s_<uvtile>.png", ("s_u0_v0.png", "s_u1_v0.png", "s_u2_v1.png")),
    "another ending": ("s.<UDIM>.exr", UDIM),
}


@pytest.mark.parametrize("name", TILES)
def test_each_tile_of_a_texture_has_its_own_picture(name: str) -> None:
    written, names = TILES[name]
    files = {"scan.obj": tiled_obj(), "scan.mtl": f"{MTL}map_Kd {written}\n".encode(), **tile_pictures(*names)}
    scan = read_scan(zipped(files))
    assert_same_body(scan)
    assert scan.notes == ((companions.OTHER_ENDING,) if name == "another ending" else ())


def test_triangles_across_the_border_of_two_tiles_are_counted() -> None:
    lines = tiled_obj().split(b"\n")
    at = [k for k, line in enumerate(lines) if line.startswith(b"vt ")]
    for face in np.flatnonzero(ACROSS == 0)[[3, 9, 15]]:  # one corner of each lies on the next tile
        lines[at[3 * face]] = b"vt 1.05 %.6f" % tiled_places()[face, 0, 1]
    materials = f"{MTL}map_Kd s.<UDIM>.png\n".encode()
    scan = read_scan(zipped({"scan.obj": b"\n".join(lines), "scan.mtl": materials, **tile_pictures(*UDIM)}))
    assert scan.notes == (tiles.ACROSS_BORDER.format(count=3),)


@pytest.mark.parametrize("written", ["s.<UDIM>.png", "s.1001.png"])
def test_a_tile_whose_picture_is_missing_is_said(written: str) -> None:
    pictures = tile_pictures(*UDIM[:2])
    scan = read_scan(zipped({"a.obj": tiled_obj(), "scan.mtl": f"{MTL}map_Kd {written}\n".encode(), **pictures}))
    assert scan.notes == (tiles.MISSING.format(count=1), UNPAINTED)
    found = shown_colours(scan)
    far, which = cKDTree(scan.vertices[scan.faces].mean(axis=1)).query(CENTRES)
    assert far.max() < 2e-5
    assert np.abs(found[which] - TRUE)[ACROSS < 2].mean() < 3.0
    assert np.ptp(found[which][ACROSS == 2], axis=0).max() <= 1  # one colour


@pytest.mark.parametrize("name", ["scan.png", "scan.1001.png", "scan.1024.png", "scan_u1_v1.png"])
def test_a_picture_without_others_beside_it_is_no_tile(name: str) -> None:
    scan = read_scan(zipped({"a.obj": tiled_obj(), "scan.mtl": f"{MTL}map_Kd {name}\n".encode(), name: saved("PNG")}))
    assert scan.notes == ()
    assert scan.uv.max() > 2.0  # repeated, as ever


def test_pictures_with_numbers_of_tiles_may_be_those_of_several_materials() -> None:
    lines = tiled_obj(0.0).split(b"\n")
    faces = [line for line in lines if line.startswith(b"f ")]
    painted = [b"usemtl m%d\n%s" % (ACROSS[k], line) for k, line in enumerate(faces)]
    mesh = [line for line in lines if not line.startswith((b"f ", b"usemtl"))] + painted
    materials = "".join(f"newmtl m{k}\nmap_Kd s.{1002 + k}.png\n" for k in range(3))
    files = {"a.obj": b"\n".join([*mesh, b""]), "scan.mtl": materials.encode()}
    assert_same_body(read_scan(zipped({**files, **tile_pictures("s.1002.png", "s.1003.png", "s.1004.png")})))


def test_tiles_of_a_ply_and_of_a_usd(monkeypatch: pytest.MonkeyPatch) -> None:
    from breastrig.scan.formats import usd

    places = tiled_places().astype("f4")
    mesh = ply(face={"texcoord": ("list uchar float", places.reshape(-1, 6))}, head="comment TextureFile s.1001.png")
    scan = read_scan(zipped({"a.ply": mesh, **tile_pictures(*UDIM)}))
    assert_same_body(scan)
    assert scan.notes == ()
    monkeypatch.setattr("breastrig.scan.formats.usd_process.usd_pieces", usd.usd_pieces)
    rows = ", ".join(f"({u:.6f}, {v:.6f})" for u, v in places.reshape(-1, 2))
    layer = re.sub(r"(primvars:st = ).*", rf'\1[{rows}] (interpolation = "faceVarying")', usda("s.<UDIM>.png").decode())
    scan = read_scan(usdz({"scan.usda": layer.encode(), **tile_pictures(*UDIM)}))
    assert_same_body(Scan(**{**vars_of(scan), "vertices": scan.vertices - [0.25, 0.0, 0.0]}))


def test_a_texture_of_more_tiles_than_there_may_be() -> None:
    lines = obj().split(b"\n")
    mesh = [b"vt %d.5 0.5" % k**2 if line[:3] == b"vt " else line for k, line in enumerate(lines)]
    files = {"scan.mtl": f"{MTL}map_Kd s.<UDIM>.png".encode(), "s.1001.png": saved("PNG")}
    with pytest.raises(TooLarge, match="tiles allowed"):
        read_scan(zipped({"a.obj": b"\n".join(mesh), **files}))


def test_a_picture_that_is_scaled_and_moved_by_its_material_lies_where_it_is_put() -> None:
    half = Image.new("RGB", (256, 128))
    half.paste(Image.fromarray(pixels()), (128, 0))
    data = painted_obj(f"{MTL}map_Kd -s 0.5 1 1 -o 0.5 0 scan.png\n", {"scan.png": saved("PNG", half)})
    assert_same_body(read_scan(data))


SAID = {
    "no name, one picture": (zipped({"a.obj": obj(""), "skin.jpg": JPEG}), companions.ONLY_PICTURE),
    "a ply, one picture": (zipped({"a.ply": ply(UV_COLUMNS["s t"]), "skin.jpg": JPEG}), companions.ONLY_PICTURE),
    "another ending": (painted(name="scan.png", file="scan.jpg"), companions.OTHER_ENDING),
    "another material file": (
        zipped({"a.obj": obj("mtllib scan.mtl"), "b.mtl": f"{MTL}map_Kd a.jpg".encode(), "a.jpg": JPEG}),
        companions.ONLY_MATERIAL,
    ),
}


@pytest.mark.parametrize("name", SAID)
def test_a_picture_that_is_found_by_guessing_is_said(name: str) -> None:
    data, sentence = SAID[name]
    scan = read_scan(data)
    assert_same_body(scan)
    assert scan.notes == (sentence,)


def test_a_missing_material_file_does_not_hide_that_the_picture_is_in_use() -> None:
    scan = read_scan(zipped({"a.obj": obj("mtllib a.mtl"), "skin.jpg": JPEG}))
    assert_same_body(scan)
    assert scan.notes == (companions.NO_MATERIAL, companions.ONLY_PICTURE)


def test_an_obj_that_is_coloured_in_part_says_so() -> None:
    rows = [list(row) if k > 20 else [] for k, row in enumerate(SHARES)]
    scan = read_scan(obj("", False, rows))
    assert scan.notes == (PARTLY_COLOURED,)
    np.testing.assert_array_equal(scan.colours[21:], WHOLE[21:])


LOST = {
    "no picture": (zipped({"a.obj": obj("")}), companions.UNNAMED),
    "two pictures": (zipped({"a.obj": obj(""), "a.jpg": JPEG, "b.jpg": JPEG}), companions.UNNAMED),
    "named, not there": (
        zipped({"a.obj": obj("mtllib a.mtl"), "a.mtl": b"newmtl skin\nmap_Kd b.jpg"}), companions.MISSING,
    ),
    "no places": (
        zipped({"a.obj": obj("mtllib a.mtl", uv=False), "a.mtl": b"newmtl skin\nmap_Kd b.jpg", "b.jpg": JPEG}),
        companions.UNPLACED,
    ),
    "a kind that is not read": (painted_obj(f"{MTL}map_Kd a.heic\n", {"a.heic": bytes(90)}), LEFT_OUT),
    "a picture that is none": (painted_obj(f"{MTL}map_Kd a.webp", {"a.webp": b"RIFF1234WEBP" + bytes(90)}), LEFT_OUT),
}  # fmt: skip


@pytest.mark.parametrize("name", LOST)
def test_colours_that_are_lost_are_said(name: str) -> None:
    data, sentence = LOST[name]
    scan = read_scan(data)
    assert_same_body(scan, coloured=False)
    assert scan.notes == (sentence,)


def test_colours_of_materials_without_pictures() -> None:
    mesh = obj("mtllib a.mtl", uv=False).replace(b"usemtl skin", b"usemtl one")
    at = [k for k, line in enumerate(mesh.split(b"\n")) if line.startswith(b"f ")][100]
    lines = mesh.split(b"\n")
    lines.insert(at, b"usemtl other")
    scan = read_scan(
        zipped({"a.obj": b"\n".join(lines), "a.mtl": b"newmtl one\nKd 1 0.4 0\nnewmtl other\nKd 0 0.2 1\n"})
    )
    found = shown_colours(scan)
    assert found is not None
    np.testing.assert_array_equal(found, [[255, 102, 0]] * 100 + [[0, 51, 255]] * (len(FACES) - 100))


GREY = Image.fromarray(pixels()).convert("L")
PICTURES: dict[str, tuple[bytes, str]] = {
    "webp": (saved("WEBP", quality=95), ""),
    "webp without loss": (saved("WEBP", lossless=True), ""),
    "tif": (saved("TIFF", compression="tiff_lzw"), ""),
    "tiff": (saved("TIFF"), ""),
    "bmp": (saved("BMP"), ""),
    "tga": (saved("TGA"), ""),
    "tga packed": (saved("TGA", compression="tga_rle"), ""),
    "gif": (saved("GIF", Image.fromarray(pixels()).quantize(256)), ""),
    "jfif": (JPEG, ""),
    "jpe": (JPEG, ""),
    "jpeg cmyk": (saved("JPEG", Image.fromarray(pixels()).convert("CMYK"), quality=95), ""),
    "png palette": (saved("PNG", Image.fromarray(pixels()).quantize(256)), ""),
    "png alpha": (saved("PNG", Image.fromarray(pixels()).convert("RGBA")), ""),
    "png grey": (saved("PNG", GREY), "grey"),
    "png grey and alpha": (saved("PNG", GREY.convert("LA")), "grey"),
    "png grey of 16 bits": (saved("PNG", Image.fromarray(np.asarray(GREY, dtype=np.uint16) * 257)), "grey"),
    "tiff grey of 16 bits": (saved("TIFF", Image.fromarray(np.asarray(GREY, dtype=np.uint16) * 257)), "grey"),
}


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_of_any_kind_is_shown(name: str) -> None:
    content, kind = PICTURES[name]
    file = f"scan.{name.split()[0]}"
    scan = read_scan(painted_obj(f"{MTL}map_Kd {file}\n", {file: content}))
    assert_same_body(scan, grey=kind == "grey")
    assert scan.notes == ()


STL = {
    "exact": stl(),
    "two bytes more": stl(more=b"\0\0"),
    "a tail": stl(more=b"made by a program" * 2),
    "title solid": stl(title=b"solid scan"),
    "text": stl_text(),
}


@pytest.mark.parametrize("name", STL)
@pytest.mark.parametrize("named", ["stl", None])
def test_an_stl_with_something_behind_it(name: str, named: str | None) -> None:
    scan = read_scan(STL[name], named)
    assert_same_body(scan, coloured=False)
    assert scan.notes == ()


@pytest.mark.parametrize("change", [str.upper, str.title, lambda word: word.replace("end", "end "), "  {}".format])
def test_an_stl_in_text_with_odd_words(change: Callable[[str], str]) -> None:
    lines = stl_text().decode().splitlines()
    assert_same_body(read_scan("\r\n".join(map(change, lines)).encode(), "stl"), coloured=False)


def test_an_stl_with_a_tail_as_long_as_a_triangle() -> None:
    for filler in (b"\xff", b"\0", b"\0\0"):
        scan = read_scan(stl(more=filler * 50), "stl")
        assert_same_body(scan, coloured=False)
        assert scan.notes == ()


@pytest.mark.parametrize("count", [0, 2**32 - 1, 100])
def test_an_stl_with_a_wrong_number_of_triangles_is_read_whole_and_it_is_said(count: int) -> None:
    scan = read_scan(stl(count=count), "stl")
    assert_same_body(scan, coloured=False)
    assert scan.notes == (WRONG_COUNT.format(count=len(FACES)),)
    with pytest.raises(BadScan, match="cut off"):
        read_scan(stl(count=len(FACES) + 1), "stl")


@pytest.mark.parametrize("title", [b"COLOR=\x80\x80\x80\xff", b"visCAM"])
def test_colours_of_an_stls_facets(title: bytes) -> None:
    five = np.round(OF_FACES / 255.0 * 31.0).astype(np.uint16)
    red, green, blue = five.T
    magics = title.startswith(b"COLOR")
    attributes = blue << 10 | green << 5 | red if magics else 0x8000 | red << 10 | green << 5 | blue
    assert_same_body(read_scan(stl(attributes, title)))


def with_texture(info: dict[str, object] | None = None, **more: object) -> bytes:
    base = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **(info or {})}}}
    options: dict[str, object] = {"material": base, "image": (JPEG, "image/jpeg")}
    return glb({"TEXCOORD_0": UV_FLIPPED}, **(options | more))


def transform(**values: object) -> dict[str, object]:
    return {"extensions": {"KHR_texture_transform": values}}


LINEAR = linear(OF_VERTICES.astype(float))
WEBP = {
    "image": (saved("WEBP", quality=95), "image/webp"),
    "texture": {"extensions": {"EXT_texture_webp": {"source": 0}}},
}
SHIFTED = (UV_FLIPPED - np.array([0.25, 0.5], "f4")) / 2.0
GRID = np.round((VERTICES - VERTICES.min(axis=0)) / np.ptp(VERTICES) * 65535).astype("u2")
QUANTISED_NODE = {"scale": [float(np.ptp(VERTICES) / 65535)] * 3, "translation": VERTICES.min(axis=0).tolist()}
GLTF = {
    "base colour": with_texture(),
    "webp": with_texture(**WEBP),
    "webp required": with_texture(**WEBP, extensions=("EXT_texture_webp",), required=True),
    "identity transform": with_texture(transform()),
    "identity transform, written out": with_texture(transform(offset=[0, 0], scale=[1, 1], rotation=0)),
    "a transform": glb(
        {"TEXCOORD_0": SHIFTED}, material={"pbrMetallicRoughness": {"baseColorTexture": {
            "index": 0, **transform(offset=[0.25, 0.5], scale=[2, 2])}}}, image=(JPEG, "image/jpeg"),
        extensions=("KHR_texture_transform",), required=True,
    ),
    "a quarter turn": glb(
        {"TEXCOORD_0": np.column_stack([-UV_FLIPPED[:, 1], UV_FLIPPED[:, 0]]).astype("f4")},
        material={"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **transform(rotation=np.pi / 2)}}},
        image=(JPEG, "image/jpeg"),
    ),
    "places of the transform": glb(
        {"TEXCOORD_0": 0 * UV_FLIPPED, "TEXCOORD_1": UV_FLIPPED}, image=(JPEG, "image/jpeg"),
        material={"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **transform(texCoord=1)}}},
    ),
    "emissive": with_texture(material={"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1]}),
    "unlit": with_texture(material={**BASE, "extensions": {"KHR_materials_unlit": {}}}),
    "glossy": with_texture(
        material={"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": {"index": 0}}}},
    ),
    "normalised bytes": glb({"COLOR_0": np.round(255 * LINEAR).astype("u1")}, normalised=("COLOR_0",)),
    "normalised shorts": glb({"COLOR_0": np.round(65535 * LINEAR).astype("u2")}, normalised=("COLOR_0",)),
    "floats": glb({"COLOR_0": LINEAR.astype("f4")}),
    "floats with opacity": glb({"COLOR_0": np.column_stack([LINEAR, np.ones(len(LINEAR))]).astype("f4")}),
    "quantised": glb({"TEXCOORD_0": np.round(65535 * UV_FLIPPED).astype("u2")}, position=GRID, node=QUANTISED_NODE,
                     material=BASE, image=(JPEG, "image/jpeg"), normalised=("TEXCOORD_0",),
                     extensions=("KHR_mesh_quantization",), required=True),
    "gltf embedded": embedded(*gltf({"TEXCOORD_0": UV_FLIPPED}, material=BASE, image=(JPEG, "image/jpeg"))),
}  # fmt: skip


@pytest.mark.parametrize("name", GLTF)
def test_a_gltf_is_read_with_its_colours(name: str) -> None:
    scan = read_scan(GLTF[name])
    assert_same_body(scan)
    assert scan.notes == ()


def with_files(folder: str = "", prefix: str = "") -> dict[str, bytes]:
    document, binary = gltf({"TEXCOORD_0": UV_FLIPPED}, material=BASE)
    document["buffers"] = [{"byteLength": len(binary), "uri": f"{prefix}my%20scan.bin"}]
    document |= {"images": [{"uri": f"{prefix}skin.jpg"}], "textures": [{"source": 0}]}
    files = {"scan.gltf": json.dumps(document).encode(), f"{prefix}my scan.bin": binary, f"{prefix}skin.jpg": JPEG}
    return {folder + name: content for name, content in files.items()}


@pytest.mark.parametrize(("folder", "prefix"), [("", ""), ("scan/", ""), ("scan/", "parts/")])
def test_a_gltf_in_a_zip_with_its_files(folder: str, prefix: str) -> None:
    files = with_files(folder, prefix)
    assert_same_body(read_scan(zipped(files)))
    with pytest.raises(BadScan, match="in another file, which is not beside it; pack both in a zip"):
        read_scan(files[folder + "scan.gltf"])


def test_a_gltf_never_reaches_outside_its_zip() -> None:
    for uri in ("../secret.bin", "/etc/passwd", "file:///etc/passwd", "https://example.org/a.bin"):
        document, binary = gltf()
        document["buffers"] = [{"byteLength": len(binary), "uri": uri}]
        with pytest.raises(BadScan, match="another file"):
            read_scan(zipped({"scan.gltf": json.dumps(document).encode(), "a.txt": b""}))


def test_a_gltf_picture_that_cannot_be_read_is_said() -> None:
    scan = read_scan(with_texture(texture={"extensions": {"KHR_texture_basisu": {"source": 0}}}))
    assert_same_body(scan, coloured=False)
    assert scan.notes == (LEFT_OUT,)
    scan = read_scan(glb(material=BASE, image=(JPEG, "image/jpeg")))
    assert scan.notes == (glb_module.UNPLACED,)


def test_a_gltf_that_meshopt_compressed_is_read_as_the_plain_one() -> None:
    document, binary = gltf({"TEXCOORD_0": UV_FLIPPED}, material=BASE, image=(JPEG, "image/jpeg"))
    views, packed = document["bufferViews"], b""
    assert isinstance(views, list)
    for accessor, view in enumerate(views[:-1]):
        count = document["accessors"][accessor]["count"]
        stride = view["byteLength"] // count
        rows = np.frombuffer(binary, np.uint8, view["byteLength"], view["byteOffset"]).reshape(count, stride)
        is_corners = accessor == 2
        values = rows.view("<u4").ravel() if is_corners else rows
        mode = "TRIANGLES" if is_corners else "ATTRIBUTES"
        content = meshopt.encode_gltf_buffer(values, mode)
        found = {"buffer": 0, "byteOffset": len(packed), "byteLength": len(content), "byteStride": stride}
        view["extensions"] = {"EXT_meshopt_compression": found | {"count": count, "mode": mode}}
        view["buffer"] = 1
        packed += content + bytes(-len(content) % 4)
    views[-1] |= {"byteOffset": len(packed)}
    packed += JPEG
    document["buffers"] = [{"byteLength": len(packed)}, {"byteLength": len(binary)}]
    document["extensionsUsed"] = document["extensionsRequired"] = ["EXT_meshopt_compression"]
    from breastrig.core.glb import pack_glb

    assert_same_body(read_scan(pack_glb(json.dumps(document).encode(), packed)))


@pytest.mark.parametrize(("head", "units", "unit"), [
    ("", "auto", "m"), ("", "m", "m"), ("metersPerUnit = 0.01", "auto", "m"), ("metersPerUnit = 0.01", "m", "m"),
    ("metersPerUnit = 1", "auto", "m"),
])  # fmt: skip
def test_the_unit_of_a_usd_is_its_own_unless_no_body_has_this_size_in_it(
    head: str, units: str, unit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from breastrig.scan.formats import usd

    monkeypatch.setattr("breastrig.scan.formats.usd_process.usd_pieces", usd.usd_pieces)
    scan = read_scan(usda(head=head), units=units)
    assert scan.unit == unit
    assert np.ptp(scan.vertices[:, 1]) == pytest.approx(np.ptp(VERTICES[:, 1]), abs=1e-5)
    assert ("which no torso is" in scan.unit_reason) == (units == "auto" and head != "metersPerUnit = 1")
    assert scan.size_known == (head != "" or units != "auto")


def test_a_usd_of_several_layers_is_read_from_its_package_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    from breastrig.scan.formats import usd

    monkeypatch.setattr("breastrig.scan.formats.usd_process.usd_pieces", usd.usd_pieces)
    root = b'#usda 1.0\n(metersPerUnit = 1)\ndef "Root" (prepend references = @./parts/body.usda@</Root>) {}\n'
    scan = read_scan(usdz({"scan.usda": root, "parts/body.usda": usda("../skin.jpg"), "skin.jpg": JPEG}))
    assert len(scan.faces) == len(FACES)
    assert scan.colour_kind == "texture"


def with_bad_vertex(bad: float, used: bool) -> bytes:
    rows = VERTICES.astype("f4")
    rows = rows if used else np.concatenate([rows, rows[:1]])
    rows = rows.copy()
    rows[-1, 1] = bad
    faces = np.zeros(len(FACES), [("n", "u1"), ("at", "<i4", 3)])
    faces["n"], faces["at"] = 3, FACES
    head = ply().split(b"end_header\n")[0].replace(b"vertex %d" % len(VERTICES), b"vertex %d" % len(rows))
    return head + b"end_header\n" + rows.tobytes() + faces.tobytes()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e35])
def test_a_vertex_that_is_no_place_costs_its_own_triangles_only(bad: float) -> None:
    scan = read_scan(with_bad_vertex(bad, used=False))
    assert_same_body(scan, coloured=False)
    assert scan.notes == ()
    scan = read_scan(with_bad_vertex(bad, used=True))
    lost = int((len(VERTICES) - 1 == FACES).any(axis=1).sum())
    assert len(scan.faces) == len(FACES) - lost
    assert scan.notes == (
        f"One vertex of this scan is not finite or beyond 1e30; the {lost} triangles there were left out.",
    )


def test_parts_without_a_place_in_the_picture_are_one_colour_and_it_is_said() -> None:
    lines = obj("mtllib a.mtl").split(b"\n")
    first = next(k for k, line in enumerate(lines) if line.startswith(b"f "))
    for k in range(first, first + 50):
        lines[k] = b"f " + b" ".join(word.split(b"/")[0] for word in lines[k].split()[1:])
    data = zipped({"a.obj": b"\n".join(lines), "a.mtl": f"{MTL}map_Kd a.jpg".encode(), "a.jpg": JPEG})
    scan = read_scan(data)
    assert scan.notes == (UNPAINTED,)
    assert scan.colour_kind == "texture"


USD_COLOURS = {
    "of vertices": ("vertex", OF_VERTICES),
    "of faces": ("uniform", OF_FACES),
    "of corners": ("faceVarying", OF_VERTICES[FACES.ravel()]),
}


@pytest.mark.parametrize("name", USD_COLOURS)
def test_colours_of_a_usd_wherever_they_stand(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from breastrig.scan.formats import usd

    monkeypatch.setattr("breastrig.scan.formats.usd_process.usd_pieces", usd.usd_pieces)
    where, colours = USD_COLOURS[name]
    data = usda(colours=linear(colours.astype(float))).replace(
        b'] (interpolation = "vertex")', f'] (interpolation = "{where}")'.encode()
    )
    scan = read_scan(data)
    moved = Scan(**{**vars_of(scan), "vertices": scan.vertices - [0.25, 0.0, 0.0]})
    assert_same_body(moved)


def vars_of(scan: Scan) -> dict[str, object]:
    return {field.name: getattr(scan, field.name) for field in fields(scan)}


def test_one_colour_of_a_usd_is_kept_from_its_process() -> None:
    """As a whole it says nothing of the skin, but with another part beside it."""
    from breastrig.scan.formats.usd_process import usd_pieces

    data = usda(colours=np.array([[1.0, 0.0, 0.0]])).replace(b'"vertex"', b'"constant"')
    (piece,) = usd_pieces(data, True).pieces
    assert piece.tint == (255, 0, 0)


def test_a_material_that_the_obj_names_otherwise_is_used_and_it_is_said() -> None:
    data = painted_obj("newmtl other\nmap_Kd scan.jpg\n", {"scan.jpg": JPEG})
    scan = read_scan(data)
    assert_same_body(scan)
    assert scan.notes == (companions.ONLY_PAINTING,)


def test_pictures_are_found_in_a_folder_and_those_in_it_but_not_behind_links(tmp_path: Path) -> None:
    (tmp_path / "textures").mkdir()
    (tmp_path / "locked").mkdir(mode=0o000)
    for name, content in {"scan.obj": obj(), "scan.mtl": f"{MTL}map_Kd textures/scan.jpg".encode()}.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "textures" / "scan.jpg").write_bytes(JPEG)
    assert_same_body(read_scan(tmp_path / "scan.obj"))
    (tmp_path / "textures").rename(tmp_path / "elsewhere.d")
    assert_same_body(read_scan(tmp_path / "scan.obj"))
    (tmp_path / "elsewhere.d" / "scan.jpg").rename(tmp_path.parent / "outside.jpg")
    (tmp_path / "elsewhere.d" / "scan.jpg").symlink_to(tmp_path.parent / "outside.jpg")
    scan = read_scan(tmp_path / "scan.obj")
    assert scan.notes == (companions.MISSING,)


def test_a_gltf_on_disk_finds_its_files(tmp_path: Path) -> None:
    for name, content in with_files().items():
        (tmp_path / name).write_bytes(content)
    assert_same_body(read_scan(tmp_path / "scan.gltf"))


def test_names_in_a_zip_without_the_flag_of_utf_8() -> None:
    data = painted(name=NFC)
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = data.find(mark)
        while at >= 0:
            flags = int.from_bytes(data[at + place : at + place + 2], "little") & ~0x800
            data = data[: at + place] + flags.to_bytes(2, "little") + data[at + place + 2 :]
            at = data.find(mark, at + 4)
    assert_same_body(read_scan(data))


@pytest.mark.parametrize("lines", ["f " + "1 2 3 " * 2000, "f 1 2 3 4"])
def test_an_obj_of_polygons_that_become_too_many_triangles(lines: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.scan.formats.obj.TRIANGLES", 500)
    with pytest.raises(TooLarge, match="triangles allowed"):
        read_scan(obj("", False) + (lines + "\n").encode() * 100)
