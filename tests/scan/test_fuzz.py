"""Damaged and random bytes never do anything but raise BadInput with a sentence."""

import re
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

SCANS = {kind: as_bytes(tube(), kind) for kind in ("ply", "obj", "stl", "stl_ascii", "glb")}
SCANS["ply_ascii"] = tube().export(file_type="ply", encoding="ascii")
SCANS["textured_glb"] = mesh_glb(toy_rig().template, toy_rig().faces, uv=toy_rig().uv, texture=picture())
SCANS["zip"] = zipped({**textured_obj(), "skin.jpg": picture()})
POINTS = front(0.0065)[0]
POINTS = POINTS[POINTS[:, 1] < -0.05]
SCANS |= {f"pcd_{form}": pcd(POINTS, form) for form in ("ascii", "binary", "binary_compressed")}
SCANS |= {
    "glb_draco": draco_glb(toy_rig().template, toy_rig().faces, uv=toy_rig().uv, texture=picture()),
    "usda": usda(),
    "usdc": usd_crate(usda()),
    "usdz": usdz({"scan.usdc": usd_crate(usda("0/skin.jpg")), "0/skin.jpg": picture()}),
}
SCANS |= {"off": off(), "3mf": three_mf(model_xml(f'<object id="1">{mesh_xml()}</object>'))}
SCANS |= {"points_ply": point_ply(POINTS), "xyz": xyz(POINTS)}
FEW = bounded(6)  # each of these takes a process of its own, or is a volume
LANDMARKS = {
    kind: landmark_file({"nipple_L": np.array([1.0, 2.5, -3.0]), "xiphoid": np.array([0.0, 1e-3, 9.0])}, kind, "mm")
    for kind in ("json", "csv", "pp", "mrk.json")
}
LABELS, COARSE = body_labels()[::2, ::2, ::2], SIZES * [2, 2, 2]
MAPS = {
    "nifti": nifti(LABELS, sizes=COARSE),
    "nrrd": nrrd(LABELS, nrrd_fields(LABELS, to_lps(sizes=COARSE))),
    "mha": meta_image(LABELS, meta_fields(LABELS, to_lps(sizes=COARSE))),
    "dicom": dicom_segmentation(LABELS, sizes=COARSE),
}
SCANS |= MAPS
ELSEWHERE = {"gltf", "3mf"}  # test_fuzz_glb.py; a 3MF is a zip


def test_no_format_is_forgotten() -> None:
    damaged_here = {file_type_of(data) for data in SCANS.values()} | ELSEWHERE
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
    data = SCANS[kind]

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
