"""Scans of every kind are read whole, in metres, in their own frame."""

import hashlib
import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.scan_files import as_bytes, picture, ply_text, textured_obj, tube, zipped
from helpers.toy_rig import toy_rig
from PIL import Image
from scipy.spatial import cKDTree

from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.pictures import joined_textures
from breastrig.scan.pictures.texture import TURNED, pixels_of
from breastrig.scan.piece import UNCOLOURED
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "stl_ascii", "glb"])
@pytest.mark.parametrize(("scale", "unit"), [(1.0, "m"), (1000.0, "mm")])
def test_a_scan_is_read_in_metres_whatever_its_kind_and_unit(kind: str, scale: float, unit: str) -> None:
    data = as_bytes(tube(scale), kind)
    scan = read_scan(data)
    rig = toy_rig()
    assert scan.unit == unit
    assert scan.faces.shape == rig.faces.shape
    assert len(scan.vertices) == len(rig.template)
    np.testing.assert_allclose(scan.vertices[scan.faces], rig.template[rig.faces], atol=1e-6)
    assert scan.sha256 == hashlib.sha256(data).hexdigest()
    assert not scan.vertices.flags.writeable
    assert scan.colour_kind == "none"
    assert not scan.shows_colour


def test_the_kind_is_decided_by_the_content_not_by_the_name(tmp_path: Path) -> None:
    path = tmp_path / "scan.obj"
    path.write_bytes(as_bytes(tube(), "ply"))
    assert len(read_scan(path).faces) == 384
    assert len(read_scan(as_bytes(tube(), "stl"), "ply").faces) == 384


def test_a_binary_stl_whose_title_begins_with_solid_is_not_taken_for_text() -> None:
    data = as_bytes(tube(), "stl")
    assert len(read_scan(b"solid".ljust(80) + data[80:]).faces) == 384


@pytest.mark.parametrize(("other", "shows"), [(180, False), (181, True)])
def test_one_colour_everywhere_shows_nothing(other: int, shows: bool) -> None:
    mesh = tube()
    colours = np.full((len(mesh.vertices), 3), 180, dtype=np.uint8)
    colours[7, 1] = other
    mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=colours)
    scan = read_scan(as_bytes(mesh, "ply"))
    assert scan.colour_kind == "vertex"
    assert scan.shows_colour == shows


def test_texture_coordinates_stay_with_their_vertices() -> None:
    scan = read_scan(zipped({**textured_obj(), "skin.jpg": picture()}))
    rig = toy_rig()
    np.testing.assert_allclose(scan.uv[scan.faces], rig.uv[rig.faces], atol=1e-5)


def test_an_obj_never_reaches_outside_its_folder(tmp_path: Path) -> None:
    inside = tmp_path / "scan"
    inside.mkdir()
    (tmp_path / "secret.jpg").write_bytes(picture())
    for name, content in textured_obj("../secret.jpg").items():
        (inside / name).write_bytes(content)
    assert read_scan(inside / "model.obj").texture is None
    (inside / "secret.jpg").symlink_to(tmp_path / "secret.jpg")
    assert read_scan(inside / "model.obj").texture is None


@pytest.mark.parametrize("turned", [False, True])
def test_a_picture_taken_with_the_camera_turned_is_used_as_stored_and_spoken_of(turned: bool) -> None:
    """As mesh programs do: texture coordinates count stored pixels."""
    rig, stream, exif = toy_rig(), io.BytesIO(), Image.Exif()
    exif[0x0112] = 6 if turned else 1
    pixels = np.random.default_rng(2).integers(0, 256, (8, 16, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(stream, "PNG", exif=exif)
    glb = mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=stream.getvalue())
    for data in (glb, zipped({**textured_obj("skin.png"), "skin.png": stream.getvalue()})):
        scan = read_scan(data)
        assert scan.picture is not None
        with Image.open(io.BytesIO(scan.picture)) as image:
            np.testing.assert_array_equal(np.asarray(image), pixels)
        assert scan.notes == ((TURNED,) if turned else ())


def test_what_the_finder_adds_to_a_zip_does_not_matter() -> None:
    files = {"scan.ply": as_bytes(tube(), "ply"), "__MACOSX/._scan.ply": b"x", ".DS_Store": b"y"}
    assert len(read_scan(zipped(files)).faces) == 384


def test_meshes_of_a_glb_are_joined_where_their_nodes_put_them() -> None:
    mesh = tube()
    moved = trimesh.transformations.translation_matrix([0.0, 0.5, 0.0])
    mirrored = np.diag([-1.0, 1.0, 1.0, 1.0])
    scene = trimesh.Scene()
    scene.add_geometry(mesh, transform=moved)
    scene.add_geometry(mesh, transform=moved @ mirrored)
    scan = read_scan(scene.export(file_type="glb"))
    assert len(scan.faces) == 2 * 384
    assert scan.vertices[:, 1].min() == pytest.approx(0.5, abs=1e-6)
    volume = trimesh.Trimesh(scan.vertices, scan.faces, process=False)
    outwards = np.einsum("fi,fi->f", volume.face_normals, volume.triangles_center * [1.0, 0.0, 1.0])
    assert (outwards > 0).all()  # the mirrored copy is not inside out


@pytest.mark.parametrize("materials", [("skin", "skin"), ("skin", "skin_2")])
def test_a_mesh_that_the_scanner_app_split_keeps_its_one_picture(materials: tuple[str, str]) -> None:
    files = textured_obj()
    lines = files["model.obj"].decode().splitlines()
    faces = [line for line in lines if line.startswith("f ")]
    rest = [line for line in lines if not line.startswith(("f ", "usemtl"))]
    first, second = (f"g part_{i}\nusemtl {name}" for i, name in enumerate(materials))
    split = [*rest, first, *faces[:200], second, *faces[200:]]
    more = b"newmtl skin_2\nKd 1 1 1\nmap_Kd skin.jpg\n"
    files |= {"model.obj": "\n".join(split).encode(), "model.mtl": files["model.mtl"] + more, "skin.jpg": picture()}
    scan = read_scan(zipped(files))
    rig = toy_rig()
    assert scan.colour_kind == "texture"
    found = np.concatenate([scan.vertices[scan.faces], scan.uv[scan.faces]], axis=2).reshape(384, -1)
    wanted = np.concatenate([rig.template[rig.faces], rig.uv[rig.faces]], axis=2).reshape(384, -1)
    order = [np.lexsort(np.round(rows.T, 4)) for rows in (found, wanted)]  # parts may come in another order
    np.testing.assert_allclose(found[order[0]], wanted[order[1]], atol=1e-5)


def with_two_pictures(first: bytes, second: bytes) -> tuple[dict[str, bytes], list[str]]:
    """The textured OBJ, whose second half has a material and picture of its own; and its lines."""
    files = textured_obj()
    lines = files["model.obj"].decode().splitlines()
    lines.insert(lines.index(next(line for line in lines if line.startswith("f "))) + 100, "usemtl other")
    more = b"newmtl other\nmap_Kd other.png\n"
    files |= {"model.obj": "\n".join(lines).encode(), "model.mtl": files["model.mtl"] + more}
    return {**files, "skin.jpg": first, "other.png": second}, lines


def ramp(width: int, height: int, blue: int) -> np.ndarray:
    """(H, W, 3): red says how far to the right, green how far down."""
    across, down = np.meshgrid(np.linspace(20, 230, width), np.linspace(20, 230, height))
    return np.stack([across, down, np.full_like(across, blue)], axis=2).round().astype(np.uint8)


def as_png(pixels: np.ndarray) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def colours_at(scan: Scan) -> np.ndarray:
    """(F, 3) of the scan's picture in the middle of each triangle."""
    assert scan.picture is not None
    pixels = pixels_of(scan.picture).astype(float)
    u, v = scan.uv[scan.faces].mean(axis=1).T
    return pixels[((1 - v) * pixels.shape[0]).astype(int), (u * pixels.shape[1]).astype(int)]


def test_two_pictures_for_one_scan_are_laid_on_one_sheet() -> None:
    wide, small = ramp(300, 120, blue=40), ramp(64, 200, blue=200)
    files, _ = with_two_pictures(as_png(wide), as_png(small))
    scan = read_scan(zipped(files))
    assert (scan.colour_kind, scan.notes) == ("texture", ())
    rig = toy_rig()
    middles = scan.vertices[scan.faces].mean(axis=1)
    wanted = cKDTree(rig.template[rig.faces].mean(axis=1)).query(middles)
    assert wanted[0].max() < 1e-5
    found = colours_at(scan)
    of_second = found[:, 2] > 120
    assert (of_second.sum(), (~of_second).sum()) == (284, 100)
    true = rig.uv[rig.faces].mean(axis=1)[wanted[1]]
    np.testing.assert_allclose(found[:, 2], np.where(of_second, 200, 40), atol=4)
    np.testing.assert_allclose(found[:, 0], 20 + 210 * true[:, 0], atol=6)
    np.testing.assert_allclose(found[:, 1], 230 - 210 * true[:, 1], atol=6)
    assert read_scan(zipped(files), texture=False).colour_kind == "none"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("tiles", "The scan has several textures, some laid out as repeated tiles, and is shown without them."),
        ("pixels", "The textures of this scan have more than 0 million pixels together and were left out; scale them"),
        ("damaged", "One of the textures of this scan is damaged, and all were left out."),
    ],
)
def test_pictures_that_cannot_be_laid_on_one_sheet_are_left_out_and_said(
    change: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    second = as_png(ramp(64, 200, blue=200))
    files, lines = with_two_pictures(picture(), second)
    if change == "tiles":
        at = next(number for number, line in enumerate(lines) if line.startswith("vt "))
        files["model.obj"] = "\n".join([*lines[:at], "vt 1.7 0.2", *lines[at + 1 :]]).encode()
    if change == "pixels":
        monkeypatch.setattr(joined_textures, "IMAGE_PIXELS", 10_000)
        monkeypatch.setattr(joined_textures, "TOO_MANY", joined_textures.TOO_MANY.replace("50", "0"))
    if change == "damaged":
        at = second.index(b"IDAT")
        files["other.png"] = second[: at + 8] + b"damage" + second[at + 14 :]
    scan = read_scan(zipped(files))
    assert scan.colour_kind == "none"
    assert [note[: len(sentence)] for note in scan.notes] == [sentence]


def test_a_part_without_a_picture_has_one_colour_and_the_others_keep_theirs() -> None:
    files, _ = with_two_pictures(as_png(ramp(300, 120, blue=40)), b"")
    files["model.mtl"] = files["model.mtl"].replace(b"map_Kd other.png\n", b"")
    del files["other.png"]
    scan = read_scan(zipped(files))
    assert (scan.colour_kind, scan.notes) == ("texture", (joined_textures.UNPAINTED,))
    found = colours_at(scan)
    plain = (np.abs(found - UNCOLOURED) < 4).all(axis=1)
    assert (plain.sum(), (~plain).sum()) == (284, 100)
    np.testing.assert_allclose(found[~plain][:, 2], 40, atol=4)
    rig = toy_rig()
    middles = scan.vertices[scan.faces].mean(axis=1)
    nearest = cKDTree(rig.template[rig.faces].mean(axis=1)).query(middles)[1]
    true = rig.uv[rig.faces].mean(axis=1)[nearest]
    np.testing.assert_allclose(found[~plain][:, 0], 20 + 210 * true[~plain][:, 0], atol=6)


def test_a_sheet_is_no_larger_than_a_texture_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joined_textures, "TEXTURE_SIDE", 256)
    files, _ = with_two_pictures(as_png(ramp(300, 220, blue=40)), as_png(ramp(180, 200, blue=200)))
    scan = read_scan(zipped(files))
    assert scan.picture is not None
    assert max(pixels_of(scan.picture).shape[:2]) <= 256
    found = colours_at(scan)
    np.testing.assert_allclose(found[:, 2], np.where(found[:, 2] > 120, 200, 40), atol=4)


def test_words_in_any_character_set_do_not_matter() -> None:
    """Comments and names, from a computer whose letters are not UTF-8."""
    for encoding in ("utf-8", "latin-1", "cp1251", "shift-jis"):
        words = {"latin-1": "Müller, Praxis für Ästhetik", "cp1251": "Иванова", "shift-jis": "山田"}.get(
            encoding, "Łódź"
        )
        word = words.encode(encoding)
        ply = as_bytes(tube(), "ply").replace(b"element vertex", b"comment " + word + b"\nelement vertex", 1)
        obj = b"# " + word + b"\no " + word + b"\ng " + word + b"\n" + as_bytes(tube(), "obj")
        stl = as_bytes(tube(), "stl_ascii").replace(b"solid", b"solid " + word)
        for data in (ply, obj, stl, b"\xef\xbb\xbf" + obj):
            assert len(read_scan(data).faces) == 384


@pytest.mark.parametrize("ends", [b"\r\n", b"\r"])
@pytest.mark.parametrize("kind", ["ply", "obj", "stl_ascii"])
def test_line_ends_of_any_system_do_not_matter(kind: str, ends: bytes) -> None:
    data = as_bytes(tube(), kind) if kind != "ply" else tube().export(file_type="ply", encoding="ascii")
    scan = read_scan(data.replace(b"\n", ends))
    np.testing.assert_array_equal(scan.faces, read_scan(data).faces)
    np.testing.assert_array_equal(scan.vertices, read_scan(data).vertices)


def test_a_binary_ply_may_have_windows_line_ends_in_its_header() -> None:
    head, body = as_bytes(tube(), "ply").split(b"end_header\n", 1)
    data = head.replace(b"\n", b"\r\n") + b"end_header\r\n" + body
    np.testing.assert_array_equal(read_scan(data).vertices, read_scan(as_bytes(tube(), "ply")).vertices)


def test_a_text_ply_of_other_types_and_elements_is_read_whole() -> None:
    """Mixed polygons, doubles, colours, lists beside the corners, elements that are no vertices."""
    rig = toy_rig()
    colours = np.random.default_rng(5).integers(0, 256, (len(rig.template), 3))
    head = "ply\nformat ascii 1.0\nelement camera 1\nproperty float view\n"
    head += f"element vertex {len(rig.template)}\n" + "".join(f"property double {axis}\n" for axis in "xyz")
    head += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    rows = ["0.5"]
    rows += [
        " ".join(map(repr, [*map(float, place), *map(int, colour)]))
        for place, colour in zip(rig.template, colours, strict=True)
    ]
    plain = f"element face {len(rig.faces)}\nproperty list uchar int vertex_indices\n"
    edges = "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    faces = ["3 " + " ".join(map(str, face)) for face in rig.faces]
    tail = ["0 1", "1 2", ""]
    scan = read_scan((head + plain + edges + "\n".join([*rows, *faces, *tail])).encode())
    np.testing.assert_array_equal(scan.vertices, rig.template)
    np.testing.assert_array_equal(scan.faces, rig.faces)
    np.testing.assert_array_equal(scan.colours, colours)
    weighted = plain + "property list uchar float weights\n"
    uneven = [f"{face} {'2 0.5 0.5' if index % 2 else '1 1.0'}" for index, face in enumerate(faces)]
    scan = read_scan((head + weighted + edges + "\n".join([*rows, *uneven, *tail])).encode())
    np.testing.assert_array_equal(scan.vertices, rig.template)
    np.testing.assert_array_equal(scan.faces, rig.faces)


def test_a_text_ply_of_single_precision_is_rounded_as_its_header_says() -> None:
    rig = toy_rig()
    scan = read_scan(ply_text(rig.template + 1.0 / 3.0, rig.faces))
    np.testing.assert_array_equal(scan.vertices, (rig.template + 1.0 / 3.0).astype(np.float32))


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_a_scan_far_from_its_origin_says_what_its_numbers_are_worth(unit: str) -> None:
    rig = toy_rig()
    factor, step = {"m": (1.0, 0.98), "mm": (1000.0, 1)}[unit]
    single = ply_text(factor * (rig.template + 10_000.0), rig.faces)
    assert read_scan(single.replace(b"float", b"double")).notes == (
        "The scan lies 10,000 m from the origin of its coordinates; results are exact there, "
        "but pictures of it may be rounded to 0.98 mm.",
    )
    (note,) = read_scan(single).notes
    assert note == (
        "The scan lies 10,000 m from the origin of its coordinates, and its file rounds them "
        f"to {step} mm; move it to the origin before it is exported."
    )
    assert read_scan(ply_text(factor * (rig.template + 50.0), rig.faces)).notes == ()
