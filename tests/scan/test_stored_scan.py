"""What the service keeps of a scan is the scan to the last bit, and nothing else that its file said."""

import hashlib
import io
from pathlib import Path

import numpy as np
import pytest
from helpers.named_scans import NAME, NAMED, named_glb, named_picture, named_zip
from helpers.walled_patient import label_map
from PIL import Image

from breastrig.core.errors import BadScan
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.normals import face_normals
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.rig.model import Rig
from breastrig.scan.pictures.texture import plain_picture
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored


def pixels(picture: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image)


@pytest.mark.parametrize("kind", NAMED)
def test_the_kept_scan_is_read_as_the_upload_was(kind: str, tmp_path: Path) -> None:
    data = NAMED[kind]()
    scan = read_scan(data, kind)
    write_stored(scan, tmp_path / "kept")
    kept = read_scan(tmp_path / "kept", STORED)
    for name in ("vertices", "faces", "colours", "uv"):
        first, second = getattr(scan, name), getattr(kept, name)
        assert (first is None) == (second is None)
        assert first is None or (first.dtype == second.dtype and first.tobytes() == second.tobytes())
    for name in ("unit", "metres_per_unit", "unit_reason", "notes", "texture", "picture", "colour_kind"):
        assert getattr(scan, name) == getattr(kept, name)
    assert kept.sha256 == hashlib.sha256(data).hexdigest()


def test_the_chest_wall_of_a_label_map_is_kept(torso: Rig, tmp_path: Path) -> None:
    scan = read_scan(label_map(torso))
    assert scan.wall is not None
    vertices, faces = scan.wall
    inner = ~boundary_vertices(faces, len(vertices))[faces].any(axis=1)  # its rim is rounded
    normals = face_normals(vertices, faces[inner])
    assert np.percentile(normals[:, 1], 90) < -0.999
    assert len(normals) > 1000
    assert len(vertices) < 1000
    write_stored(scan, tmp_path / "kept")
    kept = read_scan(tmp_path / "kept", STORED).wall
    assert kept is not None
    np.testing.assert_array_equal(kept[0], vertices)
    np.testing.assert_array_equal(kept[1], faces)
    assert b"Pectoral" not in (tmp_path / "kept").read_bytes()


@pytest.mark.parametrize("kind", NAMED)
def test_no_word_of_the_upload_is_kept(kind: str, tmp_path: Path) -> None:
    data = NAMED[kind]()
    assert NAME.encode() in data
    scan = read_scan(data, kind)
    assert len(scan.faces) >= 384
    write_stored(scan, tmp_path / "kept")
    assert NAME.encode() not in (tmp_path / "kept").read_bytes()
    assert NAME.encode() not in mesh_glb(
        scan.vertices, scan.faces, colours=scan.colours, uv=scan.uv, texture=scan.texture
    )
    assert not any(NAME in note for note in scan.notes)


@pytest.mark.parametrize("data", [named_glb(), named_zip("JPEG"), named_zip("PNG")], ids=["glb", "jpeg", "png"])
def test_the_kept_picture_has_the_pixels_of_the_file(data: bytes, tmp_path: Path) -> None:
    scan = read_scan(data)
    write_stored(scan, tmp_path / "kept")
    kept = read_scan(tmp_path / "kept", STORED)
    assert kept.picture is not None
    original = named_picture("PNG" if b".png" in data else "JPEG")
    np.testing.assert_array_equal(pixels(kept.picture), pixels(original))


def test_a_kept_scan_is_read_without_its_picture_when_nobody_needs_it(tmp_path: Path) -> None:
    write_stored(read_scan(named_glb()), tmp_path / "kept")
    scan = read_scan(tmp_path / "kept", STORED, texture=False)
    assert scan.texture is scan.picture is scan.uv is None


def test_a_kept_scan_can_be_read_in_another_unit(tmp_path: Path) -> None:
    scan = read_scan(named_zip())
    write_stored(scan, tmp_path / "kept")
    kept = read_scan(tmp_path / "kept", STORED, "m")
    assert kept.unit == "m"
    with pytest.raises(BadScan, match="no torso"):
        read_scan(tmp_path / "kept", STORED, "mm")


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04", b"ply\n"])
def test_a_damaged_kept_scan_is_one_sentence(damage: bytes, tmp_path: Path) -> None:
    (tmp_path / "kept").write_bytes(damage)
    with pytest.raises(BadScan, match=r"upload it again\.$"):
        read_scan(tmp_path / "kept", STORED)


def test_an_upload_cannot_pass_for_a_kept_scan(tmp_path: Path) -> None:
    write_stored(read_scan(named_zip()), tmp_path / f"scan.{STORED}")
    with pytest.raises(BadScan):
        read_scan(tmp_path / f"scan.{STORED}")
    with pytest.raises(BadScan):
        read_scan((tmp_path / f"scan.{STORED}").read_bytes(), STORED)


def saved(image: Image.Image, kind: str, **options: object) -> bytes:
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


NOISE = np.random.default_rng(8).integers(0, 256, (37, 53, 4)).astype(np.uint8)
PICTURES = {
    "JPEG": saved(Image.fromarray(NOISE[..., :3]), "JPEG"),
    "JPEG in steps": saved(Image.fromarray(NOISE[..., :3]), "JPEG", progressive=True, subsampling=0),
    "JPEG with restarts": saved(Image.fromarray(NOISE[..., :3]), "JPEG", restart_marker_rows=1),
    "JPEG of RGB": saved(Image.fromarray(NOISE[..., :3]), "JPEG", keep_rgb=True),
    "JPEG of CMYK": saved(Image.fromarray(NOISE, "CMYK"), "JPEG"),
    "grey JPEG": saved(Image.fromarray(NOISE[..., 0]), "JPEG"),
    "PNG": saved(Image.fromarray(NOISE), "PNG"),
    "PNG with a palette": saved(Image.fromarray(NOISE[..., :3]).quantize(16), "PNG", transparency=3),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_a_picture_without_its_metadata_has_the_same_pixels(kind: str) -> None:
    plain = plain_picture(PICTURES[kind])
    assert plain is not None
    np.testing.assert_array_equal(pixels(plain), pixels(PICTURES[kind]))
    with Image.open(io.BytesIO(plain)) as image, Image.open(io.BytesIO(PICTURES[kind])) as original:
        assert image.mode == original.mode
        assert image.convert("RGB").tobytes() == original.convert("RGB").tobytes()


@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
def test_nothing_of_a_pictures_metadata_is_left(kind: str) -> None:
    plain = plain_picture(named_picture(kind))
    assert plain is not None
    assert NAME.encode() not in plain
    with Image.open(io.BytesIO(plain)) as image:
        assert not image.getexif()
        assert set(image.info) <= {
            "jfif",
            "jfif_version",
            "jfif_unit",
            "jfif_density",
            "dpi",
            "progressive",
            "progression",
        }


@pytest.mark.parametrize("kind", PICTURES)
def test_a_picture_that_was_cut_off_is_none(kind: str) -> None:
    assert plain_picture(PICTURES[kind][: len(PICTURES[kind]) // 2]) is None


def test_a_jpeg_that_would_be_decoded_a_thousand_times_is_no_picture() -> None:
    data = PICTURES["JPEG"]
    start = data.index(b"\xff\xda")
    assert plain_picture(data[:-2] + 1000 * data[start:-2] + data[-2:]) is None
