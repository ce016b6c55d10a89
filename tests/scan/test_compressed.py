"""Compressed and nested scans outside the page: by what `breastrig[formats]` brings, or one sentence on what to do."""

import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from helpers.draco_scan import draco_glb
from helpers.scan_files import picture
from helpers.toy_rig import toy_rig
from helpers.usd_scan import usd_crate, usda, usdz

from breastrig.core.errors import BadScan
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.formats import usd
from breastrig.scan.pictures.companions import MISSING
from breastrig.scan.read import read_scan

RIG = toy_rig()
STEP = 2.0 * np.abs(RIG.template).max() / 2**16  # of the places that the tests' Draco files can say


def by_place(vertices: np.ndarray, *more: np.ndarray) -> np.ndarray:
    """(V, ...) sorted rows: Draco numbers its points anew."""
    rows = np.column_stack([np.round(vertices, 3), *more])
    return rows[np.lexsort(rows[:, :3].T)]


def test_a_glb_that_draco_compressed_has_the_triangles_colours_and_picture_of_the_plain_one() -> None:
    linear = np.random.default_rng(2).integers(0, 256, (len(RIG.template), 3)).astype(np.uint8)
    plain = read_scan(mesh_glb(RIG.template, RIG.faces, uv=RIG.uv, texture=picture()))
    upper_left = np.column_stack([RIG.uv[:, 0], 1.0 - RIG.uv[:, 1]])
    scan = read_scan(draco_glb(RIG.template, RIG.faces, uv=upper_left, texture=picture()))
    assert scan.picture == plain.picture
    assert scan.uv is not None
    assert plain.uv is not None
    corners = [np.concatenate([one.vertices[one.faces], one.uv[one.faces]], axis=2) for one in (scan, plain)]
    middles = [np.round(each.mean(axis=1), 3) for each in corners]
    orders = [np.lexsort(each.T) for each in middles]
    np.testing.assert_allclose(middles[0][orders[0]], middles[1][orders[1]], atol=1.1e-3)
    coloured = read_scan(draco_glb(RIG.template, RIG.faces, colours=linear))
    assert coloured.colours is not None
    assert len(coloured.vertices) == len(RIG.template)
    nearest = np.linalg.norm(coloured.vertices[:, None] - RIG.template[None], axis=2).argmin(axis=1)
    light = linear[nearest] / 255.0
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    np.testing.assert_array_equal(coloured.colours, np.round(255.0 * srgb))
    np.testing.assert_allclose(coloured.vertices, RIG.template[nearest], atol=STEP)


def test_without_the_decoder_one_sentence_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    data = draco_glb(RIG.template, RIG.faces)
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(BadScan, match=r'\(Draco\); install "breastrig\[formats\]"'):
        read_scan(data)


def test_damaged_draco_data_is_one_sentence() -> None:
    document, binary = split_glb(draco_glb(RIG.template, RIG.faces))
    text = json.dumps(document).encode()
    for broken in (binary[:40], bytes(len(binary)), binary[: len(binary) // 2]):
        with pytest.raises(BadScan, match=r"\.$"):
            read_scan(pack_glb(text, broken + bytes(len(binary) - len(broken))))


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """USD is read here: a process for each file takes half a second, and what these files do is known."""
    monkeypatch.setattr("breastrig.scan.formats.usd_process.usd_pieces", usd.usd_pieces)


MOVED = RIG.template + np.array([0.25, 0.0, 0.0])


def test_a_usdz_has_the_triangles_the_picture_and_the_place_that_its_scene_gives_them() -> None:
    scan = read_scan(usdz({"scan.usda": usda("0/skin.jpg"), "0/skin.jpg": picture()}))
    np.testing.assert_allclose(scan.vertices, MOVED, atol=1e-6)
    np.testing.assert_array_equal(scan.faces, RIG.faces)
    assert scan.uv is not None
    np.testing.assert_allclose(scan.uv, RIG.uv, atol=1e-6)
    plain = read_scan(mesh_glb(RIG.template, RIG.faces, uv=RIG.uv, texture=picture()))
    assert scan.picture == plain.picture
    assert scan.notes == ()


@pytest.mark.usefixtures("in_this_process")
def test_axis_and_unit_of_a_usd_are_followed() -> None:
    scan = read_scan(usda(head='metersPerUnit = 0.5\n    upAxis = "Z"'))
    x, y, z = 0.5 * MOVED.T
    np.testing.assert_allclose(scan.vertices, np.column_stack([x, z, -y]), atol=1e-6)
    assert scan.unit == "m"


@pytest.mark.usefixtures("in_this_process")
def test_colours_of_points_in_a_usd_are_kept() -> None:
    linear = np.random.default_rng(4).integers(0, 256, (len(RIG.template), 3)) / 255.0
    scan = read_scan(usda(colours=linear))
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    assert np.abs(scan.colours - 255.0 * srgb).max() < 0.6


def test_a_usd_crate_is_read_as_its_text() -> None:
    np.testing.assert_allclose(read_scan(usd_crate(usda())).vertices, MOVED, atol=1e-6)


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("kind", ["references", "payload"])
def test_no_other_layer_is_ever_opened(kind: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "other.usda").write_bytes(usda())
    empty = f'#usda 1.0\ndef "Root" (prepend {kind} = @{tmp_path}/other.usda@</Root>) {{}}\n'.encode()
    below = f"#usda 1.0\n(subLayers = [@{tmp_path}/other.usda@])\n".encode()
    for data in (empty, below):
        for packed in (data, usdz({"scan.usda": data, "other.usda": usda()})):
            with pytest.raises(BadScan, match="in other files"):
                read_scan(packed)
    variant = '(\n variants = { string v = "a" }\n prepend variantSets = "v"\n)'
    inside = f'variantSet "v" = {{\n "a" (\n prepend {kind} = @{tmp_path}/other.usda@</Root>\n) {{\n }}\n }}'
    with pytest.raises(BadScan, match="in other files"):
        read_scan(f'#usda 1.0\ndef "Root" {variant} {{\n {inside}\n}}\n'.encode())
    assert "Mustermann" not in "".join(capfd.readouterr())


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("name", ["/etc/passwd", "../../secret.jpg", "https://example.org/a.jpg", "missing.png"])
def test_a_picture_that_a_usd_names_elsewhere_is_left_out_and_said(name: str) -> None:
    scan = read_scan(usdz({"scan.usda": usda(name), "0/skin.jpg": picture()}))
    assert scan.texture is None
    assert scan.notes == (MISSING,)


def test_without_pixars_library_one_sentence_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BadScan, match=r'USD file; install "breastrig\[formats\]"'):
        read_scan(usda())


@pytest.mark.usefixtures("in_this_process")
def test_a_usd_that_is_wrong_is_one_sentence() -> None:
    text = usda()
    wrong = [
        text[:400],
        text.replace(b"faceVertexIndices = [0", b"faceVertexIndices = [9999"),
        text.replace(b"faceVertexCounts = [3", b"faceVertexCounts = [-3"),
        text.replace(b"point3f[] points", b"string[] points"),
        b"PXR-USDC" + bytes(200),
        b"#usda 1.0\n",
        usdz({"scan.usda": text}, zipfile.ZIP_DEFLATED),
        usdz({"scan.usda": text})[:900],
    ]
    for data in wrong:
        with pytest.raises(BadScan, match=r"\.$"):
            read_scan(data)


def test_a_usd_that_ends_its_reader_or_fills_the_memory_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    crate = bytearray(usd_crate(usda()))
    sections = int.from_bytes(crate[16:24], "little")  # where the table of contents begins
    crate[sections : sections + 8] = (2**40).to_bytes(8, "little")
    with pytest.raises(BadScan, match=r"\.$"):
        read_scan(bytes(crate))
    monkeypatch.setattr("sys.executable", "/bin/false")
    with pytest.raises(BadScan, match="more memory or time"):
        read_scan(usda())
