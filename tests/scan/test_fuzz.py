"""Damaged and random bytes never do anything but raise BadInput with a sentence."""

import numpy as np
import pytest
from helpers.damage import BOUNDED, Edits, bounded, damage, damaged
from helpers.draco_scan import draco_glb
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
FEW = bounded(6)  # each of these takes a process of its own
LANDMARKS = {
    kind: landmark_file({"nipple_L": np.array([1.0, 2.5, -3.0]), "xiphoid": np.array([0.0, 1e-3, 9.0])}, kind, "mm")
    for kind in ("json", "csv", "pp", "mrk.json")
}


@pytest.mark.parametrize("kind", SCANS)
def test_a_damaged_scan_is_refused_or_sound(kind: str) -> None:
    data = SCANS[kind]

    @(FEW if kind.startswith("usd") else bounded(80))
    @given(damage(len(data)))
    def run(edits: Edits) -> None:
        refused_or_sound(damaged(data, edits), kind.split("_")[0])

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
