"""Damaged and random bytes never do anything but raise BadInput with a sentence."""

import re
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from helpers.damage import BOUNDED, Edits, bounded, damage, damaged
from helpers.draco_scan import draco_glb
from helpers.grid_files import meta_fields, meta_image, nrrd, nrrd_fields, to_lps
from helpers.label_maps import SIZES, body_labels, dicom_segmentation, nifti
from helpers.other_meshes import mesh_xml, model_xml, off, three_mf
from helpers.point_files import front, pcd, point_ply, xyz
from helpers.refusals import refused_or_sound, sound_landmarks_or_refused
from helpers.scan_files import as_bytes, picture, textured_obj, tube, zipped
from helpers.toy_rig import toy_rig
from helpers.usd_scan import usd_crate, usda, usdz
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.errors import BadInput
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.file_type import FILE_TYPES, file_type_of
from breastrig.scan.formats.archive import MESH_RANK, VOLUMES
from breastrig.scan.landmarks.landmark_files import landmark_file
from breastrig.scan.read import read_scan

pytestmark = pytest.mark.long

FEW = bounded(6)  # each of these takes a process of its own, or is a volume
LANDMARKS = {
    kind: landmark_file({"nipple_L": np.array([1.0, 2.5, -3.0]), "xiphoid": np.array([0.0, 1e-3, 9.0])}, kind, "mm")
    for kind in ("json", "csv", "pp", "mrk.json")
}


@cache
def points() -> np.ndarray:
    found = front(0.0065)[0]
    return np.asarray(found[found[:, 1] < -0.05])


@cache
def labels() -> np.ndarray:
    return body_labels()[::2, ::2, ::2]


def painted(write: Callable[..., bytes]) -> bytes:
    rig = toy_rig()
    return write(rig.template, rig.faces, uv=rig.uv, texture=picture())


COARSE = SIZES * [2, 2, 2]
MAPS: dict[str, Callable[[], bytes]] = {
    "nifti": lambda: nifti(labels(), sizes=COARSE),
    "nrrd": lambda: nrrd(labels(), nrrd_fields(labels(), to_lps(sizes=COARSE))),
    "mha": lambda: meta_image(labels(), meta_fields(labels(), to_lps(sizes=COARSE))),
    "dicom": lambda: dicom_segmentation(labels(), sizes=COARSE),
}
SCANS: dict[str, Callable[[], bytes]] = {  # made where they are damaged, not where tests are collected
    **{kind: partial(as_bytes, tube(), kind) for kind in ("ply", "obj", "stl", "stl_ascii", "glb")},
    "ply_ascii": lambda: tube().export(file_type="ply", encoding="ascii"),
    "textured_glb": lambda: painted(mesh_glb),
    "zip": lambda: zipped({**textured_obj(), "skin.jpg": picture()}),
    "pcd_ascii": lambda: pcd(points(), "ascii"),
    "pcd_binary": lambda: pcd(points(), "binary"),
    "pcd_binary_compressed": lambda: pcd(points(), "binary_compressed"),
    "glb_draco": lambda: painted(draco_glb),
    "usda": usda,
    "usdc": lambda: usd_crate(usda()),
    "usdz": lambda: usdz({"scan.usdc": usd_crate(usda("0/skin.jpg")), "0/skin.jpg": picture()}),
    "off": off,
    "3mf": lambda: three_mf(model_xml(f'<object id="1">{mesh_xml()}</object>')),
    "points_ply": lambda: point_ply(points()),
    "xyz": lambda: xyz(points()),
    **MAPS,
}
ELSEWHERE = {"gltf", "3mf"}  # test_fuzz_glb.py; a 3MF is a zip


def test_no_format_is_forgotten() -> None:
    damaged_here = {file_type_of(made()) for made in SCANS.values()} | ELSEWHERE
    assert set(FILE_TYPES) - damaged_here == set(), "add a small file of this format to SCANS above: it is then damaged"
    in_zips = {f".{ending}" for ending in (*MESH_RANK, *VOLUMES)} | {".zip", ".nii.gz"}
    missing = {ending for endings in FILE_TYPES.values() for ending in endings} - in_zips
    assert missing == set(), (
        "add the ending to MESH_RANK of scan/formats/archive.py: else a zip's scan of it is not seen"
    )


@pytest.mark.parametrize("ending", [ending for endings in FILE_TYPES.values() for ending in endings])
def test_every_format_is_in_the_table_of_the_docs(ending: str, repository: Path) -> None:
    words = (repository / "docs/reference/file_formats.md").read_text().lower()
    table = words.split("## scans")[1].split("\npictures:")[0]
    assert re.search(rf"\b{ending[1:]}\b", table), "add the format to the table of docs/reference/file_formats.md"


@pytest.mark.parametrize("kind", SCANS)
def test_a_damaged_scan_is_refused_or_sound(kind: str) -> None:
    data = SCANS[kind]()

    @(FEW if kind.startswith("usd") or kind in MAPS else bounded(80))
    @given(damage(len(data)))
    def run(edits: Edits) -> None:
        refused_or_sound(damaged(data, edits), kind.split("_")[0], "auto" if kind in MAPS else "m")

    run()


@BOUNDED
@given(st.binary(max_size=300), st.sampled_from([None, "ply", "obj", "stl", "glb", "zip"]))
def test_random_bytes_are_refused(data: bytes, named: str | None) -> None:
    with pytest.raises(BadInput):
        read_scan(data, named)


@BOUNDED
@given(st.sampled_from(sorted(LANDMARKS)), st.data())
def test_a_damaged_landmark_file_is_refused_or_sound(kind: str, source: st.DataObject) -> None:
    sound_landmarks_or_refused(damaged(LANDMARKS[kind], source.draw(damage(len(LANDMARKS[kind])))))


@BOUNDED
@given(st.text(max_size=200))
def test_random_text_is_no_landmark_file_or_a_sound_one(text: str) -> None:
    sound_landmarks_or_refused(text.encode("utf-8", "surrogatepass"))
