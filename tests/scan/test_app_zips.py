"""Zips as scanner apps send them: the mesh that is meant is found, and all else is left packed."""

import zipfile
from unittest.mock import patch

import numpy as np
import pytest
from helpers.scan_files import as_bytes, picture, textured_obj, tube, zipped
from helpers.toy_rig import toy_rig

from breastrig.core.errors import BadScan
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.read import read_scan

PAINTED = textured_obj()
PLAIN = as_bytes(tube(1.02), "obj")
FRAMES = {f"frame_{index:05}.{ending}": b"x" for index in range(40) for ending in ("jpg", "json")}


def renamed(obj: str, mtl: str, jpg: str) -> dict[str, bytes]:
    """The textured scan under other names."""
    material = PAINTED["model.mtl"].replace(b"skin.jpg", jpg.rsplit("/", 1)[-1].encode())
    mesh = PAINTED["model.obj"].replace(b"model.mtl", mtl.rsplit("/", 1)[-1].encode())
    return {obj: mesh, mtl: material, jpg: picture()}


APPS = {
    "3D Scanner App": {
        "2026_02_10/annotations.json": b"[]",
        "2026_02_10/export.obj": PLAIN,
        "2026_02_10/export_refined.obj": PLAIN + b"# finer, and larger than the textured one" * 1000,
        **{f"2026_02_10/{name}": content for name, content in FRAMES.items()},
        "2026_02_10/info.json": b"{}",
        **renamed("2026_02_10/textured_output.obj", "2026_02_10/textured_output.mtl", "2026_02_10/textured_output.jpg"),
        "2026_02_10/thumb_00000.jpg": b"x",
        "2026_02_10/world_map.arkit": b"x",
    },
    "Polycam": {**renamed("2_10_2026.obj", "2_10_2026.mtl", "material_0.jpg"), "__MACOSX/._2_10_2026.obj": b"x"},
    "Scaniverse": renamed(
        "Scan 2026-02-10/scan.obj", "Scan 2026-02-10/scan.mtl", "Scan 2026-02-10/textures/scan_0.jpg"
    ),
    "Structure": {**renamed("Model.obj", "Model.mtl", "Model.jpg"), "Preview.jpg": b"x"},
    "a scanner's folder": {
        **renamed("A17/A17_tex.obj", "A17/A17_tex.mtl", "A17/A17_tex.jpg"),
        "A17/A17_mesh.ply": as_bytes(tube(), "ply"),
        "A17/A17_pc.ply": as_bytes(tube(), "ply"),
    },
    "with a preview of another name": {
        "scan/model.glb": mesh_glb(toy_rig().template, toy_rig().faces, uv=toy_rig().uv, texture=picture()),
        "preview/low.obj": PLAIN,
        "preview/preview.jpg": b"x",
    },
}


@pytest.mark.parametrize("app", APPS)
def test_the_textured_mesh_is_read_with_its_own_picture(app: str) -> None:
    scan = read_scan(zipped(APPS[app]))
    rig = toy_rig()
    assert scan.colour_kind == "texture"
    np.testing.assert_allclose(scan.vertices[scan.faces], rig.template[rig.faces], atol=1e-6)
    np.testing.assert_allclose(scan.uv[scan.faces], rig.uv[rig.faces], atol=1e-5)


def test_which_of_several_meshes_was_read_is_said() -> None:
    assert read_scan(zipped(APPS["3D Scanner App"])).notes == (
        "The zip holds this scan 3 times; the OBJ with the most on it was read.",
    )
    assert read_scan(zipped(APPS["Polycam"])).notes == ()


def test_what_is_not_needed_is_never_unpacked() -> None:
    unpacked: list[str] = []
    read = zipfile.ZipFile.read

    def seen(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
        unpacked.append(entry.filename.rsplit("/", 1)[-1])
        return read(archive, entry)

    data = zipped({**APPS["3D Scanner App"], "2026_02_10/bomb.bin": bytes(10**7), "2026_02_10/inner.zip": b"x"})
    with patch.object(zipfile.ZipFile, "read", seen):
        read_scan(data)
    assert unpacked == ["textured_output.obj", "textured_output.mtl", "textured_output.jpg"]


def test_the_picture_beside_the_mesh_comes_before_others_of_its_name() -> None:
    files = {f"scan/{name}": content for name, content in PAINTED.items()}
    green = picture("JPEG", (4, 4))
    scan = read_scan(zipped({"skin.jpg": green, "other/skin.jpg": green, **files, "scan/skin.jpg": picture()}))
    assert scan.picture is not None
    assert len(scan.picture) > 0
    assert scan.picture == read_scan(zipped({**PAINTED, "skin.jpg": picture()})).picture


def test_two_bodies_in_one_zip_are_never_chosen_between() -> None:
    body = as_bytes(tube(), "ply")
    for names in (("standing.ply", "supine.ply"), ("a/model.ply", "b/model.ply"), ("anna.ply", "anna_2.ply")):
        with pytest.raises(BadScan, match="2 scans"):
            read_scan(zipped(dict.fromkeys(names, body)))
