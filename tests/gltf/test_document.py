"""The JSON of a glTF document: what pygltflib itself writes, faster."""

import json

import pygltflib
import pytest

from breastrig.gltf import document as ours


def whole() -> ours.Document:
    """Something of every kind."""
    ink = pygltflib.Material(
        name="ink",
        doubleSided=True,
        pbrMetallicRoughness=pygltflib.PbrMetallicRoughness(
            baseColorFactor=[0.5, 0.25, 1e-7, 1.0], metallicFactor=0.0, baseColorTexture=pygltflib.TextureInfo(index=0)
        ),
        extensions={"KHR_materials_unlit": {}},
    )
    primitive = pygltflib.Primitive(
        attributes=ours.Attributes(POSITION=0, COLOR_0=1),
        indices=2,
        mode=pygltflib.LINE_STRIP,
        material=0,
        targets=[ours.Attributes(POSITION=0), ours.Attributes(NORMAL=0)],
        extras={
            "label": "",
            "closed": False,
            "nothing": [],
            "deep": {"empty": {}, "full": [1, [], {"a": None, "b": 2}]},
        },
    )
    channel = pygltflib.AnimationChannel(sampler=0, target=pygltflib.AnimationChannelTarget(node=0, path="weights"))
    document = ours.Document(
        asset=pygltflib.Asset(generator="ä", extras={"notice": "no"}),
        scene=0,
        scenes=[pygltflib.Scene(nodes=[0])],
        nodes=[ours.Node(name="a", mesh=0, children=[1], translation=[0.0, -0.5, 1e-9]), ours.Node(name="b", skin=0)],
        meshes=[pygltflib.Mesh(name="m", primitives=[primitive], extras={"targetNames": ["x"]})],
        materials=[ink, pygltflib.Material(name="plain")],
        accessors=[
            pygltflib.Accessor(bufferView=0, componentType=pygltflib.FLOAT, count=3, type="VEC3", min=[0.1], max=[2.5])
        ],
        bufferViews=[pygltflib.BufferView(buffer=0, byteLength=36, target=pygltflib.ARRAY_BUFFER)],
        buffers=[pygltflib.Buffer(byteLength=36, uri="x.bin")],
        images=[pygltflib.Image(mimeType="image/png", bufferView=0)],
        samplers=[pygltflib.Sampler(magFilter=pygltflib.LINEAR, minFilter=pygltflib.LINEAR_MIPMAP_LINEAR)],
        textures=[pygltflib.Texture(sampler=0, source=0)],
        skins=[pygltflib.Skin(name="s", joints=[1], skeleton=1, inverseBindMatrices=0)],
        animations=[
            pygltflib.Animation(name="r", channels=[channel], samplers=[pygltflib.AnimationSampler(input=0, output=0)])
        ],
        extensionsUsed=["KHR_materials_unlit"],
    )
    return document


def test_the_json_is_that_of_the_library() -> None:
    document = whole()
    assert ours.json_of(document).decode() == document.gltf_to_json(separators=(",", ":"), indent=None)


def test_an_empty_document_too() -> None:
    assert ours.json_of(ours.Document()) == ours.Document().gltf_to_json(separators=(",", ":"), indent=None).encode()


def test_a_nodes_weights_are_written() -> None:
    document = ours.Document(nodes=[ours.Node(name="a", weights=[0.0, 0.5])])
    assert json.loads(ours.json_of(document))["nodes"] == [{"name": "a", "weights": [0.0, 0.5]}]


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        ours.json_of(ours.Document(nodes=[ours.Node(scale=[float("nan"), 1.0, 1.0])]))
