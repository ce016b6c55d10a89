"""A scan for the page: the same triangles, smooth normals, colours as linear light, the texture inside."""

import io

import numpy as np
import pytest
from helpers.scan_files import picture
from helpers.toy_rig import toy_rig
from PIL import Image

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.mesh_glb import mesh_glb


def opened(data: bytes) -> tuple[dict, GltfArrays, dict]:
    document, binary = split_glb(data)
    return document, GltfArrays(document, binary), document["meshes"][0]["primitives"][0]


def test_vertices_and_triangles_are_the_scans_own() -> None:
    rig = toy_rig()
    document, arrays, primitive = opened(mesh_glb(rig.template, rig.faces, extras={"scan": "abc"}))
    np.testing.assert_allclose(arrays.read(primitive["attributes"]["POSITION"]), rig.template, atol=1e-7)
    np.testing.assert_array_equal(arrays.read(primitive["indices"]).reshape(-1, 3), rig.faces)
    normals = arrays.read(primitive["attributes"]["NORMAL"])
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    assert (np.einsum("vi,vi->v", normals, rig.template * [1, 0, 1]) > 0).all()
    assert document["asset"]["extras"]["scan"] == "abc"
    assert document["asset"]["extras"]["notice"].startswith("Research use only")


def test_more_than_65535_vertices_are_numbered_with_32_bits() -> None:
    vertices = np.random.default_rng(1).normal(size=(70_000, 3))
    faces = np.arange(69_999).reshape(-1, 3)
    _, arrays, primitive = opened(mesh_glb(vertices, faces))
    np.testing.assert_array_equal(arrays.read(primitive["indices"]).reshape(-1, 3), faces)


def test_given_normals_are_kept() -> None:
    rig = toy_rig()
    up = np.tile([0.0, 1.0, 0.0], (len(rig.template), 1))
    _, arrays, primitive = opened(mesh_glb(rig.template, rig.faces, normals=up))
    np.testing.assert_array_equal(arrays.read(primitive["attributes"]["NORMAL"]), up)


@pytest.mark.parametrize("channels", [3, 4])
def test_colours_become_opaque_linear_light(channels: int) -> None:
    rig = toy_rig()
    colours = np.zeros((len(rig.template), channels), np.uint8)
    colours[:, 0], colours[:, 1] = 255, 188  # 188 in sRGB is half the light
    _, arrays, primitive = opened(mesh_glb(rig.template, rig.faces, colours=colours))
    found = arrays.read(primitive["attributes"]["COLOR_0"])
    np.testing.assert_allclose(found[0], [1.0, 0.5029, 0.0, 1.0], atol=1e-4)


@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
def test_a_texture_lies_inside_the_file_and_wins_over_colours(kind: str) -> None:
    rig = toy_rig()
    colours = np.zeros((len(rig.template), 3), np.uint8)
    data = mesh_glb(rig.template, rig.faces, colours=colours, uv=rig.uv, texture=picture(kind))
    document, arrays, primitive = opened(data)
    assert "COLOR_0" not in primitive["attributes"]
    uv = arrays.read(primitive["attributes"]["TEXCOORD_0"])
    np.testing.assert_allclose(uv, np.stack([rig.uv[:, 0], 1.0 - rig.uv[:, 1]], axis=1), atol=1e-6)
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    content = split_glb(data)[1][view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    assert Image.open(io.BytesIO(content)).format == kind
    assert document["images"][0]["mimeType"] == f"image/{kind.lower()}"


def test_the_same_mesh_gives_the_same_bytes() -> None:
    rig = toy_rig()
    assert mesh_glb(rig.template, rig.faces) == mesh_glb(rig.template, rig.faces)
