"""Lines for other programs: names, places in metres, closed or open, colours."""

import numpy as np

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.lines.lines_glb import lines_glb


def test_each_line_is_a_node_with_its_points_in_metres() -> None:
    rng = np.random.default_rng(3)
    open_line, ring = rng.normal(size=(7, 3)), rng.normal(size=(5, 3))
    content = lines_glb(
        [("midline", open_line, False, (255, 0, 0)), ("breast_L", ring, True, (0, 0, 0))], {"unit": "m"}
    )
    document, binary = split_glb(content)
    arrays = GltfArrays(document, binary)
    assert [node["name"] for node in document["nodes"]] == ["midline", "breast_L"]
    for node, points, mode in zip(document["nodes"], (open_line, ring), (3, 2), strict=True):
        primitive = document["meshes"][node["mesh"]]["primitives"][0]
        assert primitive["mode"] == mode
        np.testing.assert_allclose(arrays.read(primitive["attributes"]["POSITION"]), points, atol=1e-6)
    colours = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in document["materials"]]
    assert colours == [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]
    assert document["asset"]["extras"]["notice"].startswith("Research use only")
    assert content == lines_glb(
        [("midline", open_line, False, (255, 0, 0)), ("breast_L", ring, True, (0, 0, 0))], {"unit": "m"}
    )


def test_a_single_point_is_a_point() -> None:
    document, _ = split_glb(lines_glb([("spot", np.zeros((1, 3)), True, (0, 0, 0))]))
    assert document["meshes"][0]["primitives"][0]["mode"] == 0
