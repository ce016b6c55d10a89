import numpy as np
import pytest
from helpers.scan_files import picture

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.gltf.plain_mesh import plain_mesh

VERTICES = np.random.default_rng(3).normal(size=(30, 3))
FACES = np.arange(30).reshape(10, 3)
COLOURS = {
    "vertex": {"colours": np.full((30, 3), 200, dtype=np.uint8)},
    "texture": {"uv": np.full((30, 2), 0.5), "texture": picture()},
    "none": {},
}


@pytest.mark.parametrize("kind", COLOURS)
def test_shape_stays_and_colour_goes(kind: str) -> None:
    coloured = mesh_glb(VERTICES, FACES, **COLOURS[kind])
    plain = plain_mesh(coloured)
    documents = [split_glb(glb) for glb in (coloured, plain)]
    before, after = (document["meshes"][0]["primitives"][0] for document, _ in documents)
    assert set(after["attributes"]) == {"POSITION", "NORMAL"}
    assert not documents[1][0].get("images")
    assert not documents[1][0].get("textures")
    arrays = [GltfArrays(*document) for document in documents]
    for place in ("POSITION", "NORMAL"):
        values = [each.read(one["attributes"][place]) for each, one in zip(arrays, (before, after), strict=True)]
        assert np.allclose(*values, atol=1e-7)
    assert np.array_equal(arrays[0].read(before["indices"]), arrays[1].read(after["indices"]))
    assert plain == plain_mesh(mesh_glb(VERTICES, FACES))
