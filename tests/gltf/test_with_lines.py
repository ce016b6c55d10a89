"""The plan in a fit's own file: lines where they are on the scan, none of the fit's own drawing beside them."""

import numpy as np
import pytest
from helpers.random_pose import random_parameters

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.lines.lines_glb import Ball, with_lines
from breastrig.gltf.replay import fitted_glb
from breastrig.rig.model import Rig


def test_the_plan_stands_beside_the_rig_and_instead_of_the_fits_own_drawing(
    toy_rig: Rig, rng: np.random.Generator
) -> None:
    before = fitted_glb(toy_rig, [random_parameters(toy_rig, rng)], [0.0], toy_rig.drawings[0], {"scan_unit": "mm"})
    line, ring = rng.normal(size=(7, 3)), rng.normal(size=(5, 3))
    content = with_lines(before, [("Line 1", line, False, (16, 16, 16)), ("tumour_L", ring, True, (200, 0, 0))])
    document, binary = split_glb(content)
    arrays, nodes = GltfArrays(document, binary), document["nodes"]
    shown = [nodes[k]["name"] for k in document["scenes"][0]["nodes"]]
    assert shown[-1] == "plan"
    assert not any(name.startswith("drawing_") for name in shown)
    children = [nodes[k] for k in nodes[document["scenes"][0]["nodes"][-1]]["children"]]
    assert [node["name"] for node in children] == ["Line 1", "tumour_L"]
    for node, points in zip(children, (line, ring), strict=True):
        primitive = document["meshes"][node["mesh"]]["primitives"][0]
        np.testing.assert_allclose(arrays.read(primitive["attributes"]["POSITION"]), points, atol=1e-6)
    rig_before, numbers = split_glb(before)
    mesh = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    np.testing.assert_array_equal(
        arrays.read(mesh),
        GltfArrays(rig_before, numbers).read(rig_before["meshes"][0]["primitives"][0]["attributes"]["POSITION"]),
    )
    assert document["asset"]["extras"] == rig_before["asset"]["extras"]


def test_an_empty_plan_takes_the_drawing_out(toy_rig: Rig, rng: np.random.Generator) -> None:
    before = fitted_glb(toy_rig, [random_parameters(toy_rig, rng)], [0.0], toy_rig.drawings[0], {})
    document, _ = split_glb(with_lines(before, []))
    assert [document["nodes"][k]["name"] for k in document["scenes"][0]["nodes"]][-1] != "plan"
    assert len(document["scenes"][0]["nodes"]) == len(split_glb(before)[0]["scenes"][0]["nodes"]) - 1


def test_a_lesion_is_a_ball_of_its_size_at_its_place_with_its_numbers(toy_rig: Rig, rng: np.random.Generator) -> None:
    before = fitted_glb(toy_rig, [random_parameters(toy_rig, rng)], [0.0], toy_rig.drawings[0], {})
    center, line = np.array([0.1, 0.2, -0.3]), ("Line 1", rng.normal(size=(7, 3)), False, (16, 16, 16))
    ball = Ball("lesion_MRI 1", center, 0.008, (184, 50, 128), {"radius_mm": 8.0})
    document, binary = split_glb(with_lines(before, [line], [ball]))
    (node,) = (each for each in document["nodes"] if each.get("name") == "lesion_MRI 1")
    assert node["extras"] == {"radius_mm": 8.0}
    primitive = document["meshes"][node["mesh"]]["primitives"][0]
    arrays = GltfArrays(document, binary)
    points = np.array(node["scale"]) * arrays.read(primitive["attributes"]["POSITION"]) + node["translation"]
    np.testing.assert_allclose(np.linalg.norm(points - center, axis=1), 0.008, rtol=1e-5)
    corners = points[arrays.read(primitive["indices"]).reshape(-1, 3)]
    volume = np.einsum("fi,fi->", corners[:, 0] - center, np.cross(corners[:, 1] - center, corners[:, 2] - center)) / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 0.008**3, rel=0.02)
