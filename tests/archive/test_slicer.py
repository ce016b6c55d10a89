"""The scene for 3D Slicer: well-formed, complete, in the patient's axes, and its markups as their schema has them."""

import io
import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import trimesh
from helpers.written_fit import write_fit

from breastrig.cli.main import main
from breastrig.rig.model import Rig

KINDS = ("Fiducial", "Line", "Angle", "Curve", "ClosedCurve", "Plane", "ROI")  # of the markups' schema 1.0.3
STATES = ("undefined", "preview", "defined", "missing")


def test_a_scene_holds_surfaces_landmarks_and_lines_to_the_left_back_and_head(rig: Rig, tmp_path: Path) -> None:
    turned = np.array(rig.template)[:, [2, 0, 1]] + [0.1, 0.2, 0.3]
    fit = write_fit(tmp_path / "fit", rig, turned, np.full(len(turned), 0.002), unit="m")
    assert main(["export", str(fit), "-o", str(tmp_path / "files"), "--slicer"]) == 0
    with zipfile.ZipFile(tmp_path / "files" / "scene.mrb") as bundle:
        files = {name.removeprefix("BreastRig/"): bundle.read(name) for name in bundle.namelist()}
    scene = ElementTree.fromstring(files["BreastRig.mrml"])
    nodes = {each.attrib["id"]: each for each in scene}
    assert len(nodes) == len(scene)
    assert {each.attrib["fileName"] for each in scene if "fileName" in each.attrib} < set(files)
    for each in scene:
        for reference in each.attrib.get("references", "").split(";")[:-1]:
            assert reference.partition(":")[2] in nodes
    stored = [each for each in scene if each.tag.endswith("Storage")]
    assert {each.attrib["coordinateSystem"] for each in stored} == {"LPS"}

    skin = trimesh.load(io.BytesIO(files["Data/skin.ply"]), file_type="ply", process=False)
    true = 1e3 * np.array(rig.template)[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    offset = (true - skin.vertices).mean(axis=0)
    assert np.allclose(skin.vertices + offset, true, atol=0.01)
    markups = {name: json.loads(content) for name, content in files.items() if name.endswith(".mrk.json")}
    for document in markups.values():
        assert document["@schema"].endswith("markups-schema-v1.0.3.json#")
        [markup] = document["markups"]
        assert markup["type"] in KINDS
        assert (markup["coordinateSystem"], markup["coordinateUnits"]) == ("LPS", "mm")
        assert all(each["positionStatus"] in STATES and len(each["position"]) == 3 for each in markup["controlPoints"])
    [points] = [each["markups"][0]["controlPoints"] for name, each in markups.items() if "landmarks" in name]
    known = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    for each in points:
        expected = 1e3 * known[each["label"]][[0, 2, 1]] * [1.0, -1.0, 1.0]
        assert np.allclose(np.array(each["position"]) + offset, expected, atol=0.01)
    assert len(markups) == 2  # the landmarks, and the drawing's one line
