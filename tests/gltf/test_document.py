"""The JSON of a glTF document: what pygltflib writes of the same objects."""

import json
from typing import Any

import pygltflib
import pytest

from breastrig.gltf import document as ours


def whole(kinds: Any, document_kind: Any) -> Any:
    """Something of every kind, of the classes in the module `kinds`."""
    ink = kinds.Material(
        name="ink",
        doubleSided=True,
        pbrMetallicRoughness=kinds.PbrMetallicRoughness(
            baseColorFactor=[0.5, 0.25, 1e-7, 1.0], metallicFactor=0.0, baseColorTexture=kinds.TextureInfo(index=0)
        ),
        extensions={"KHR_materials_unlit": {}},
    )
    primitive = kinds.Primitive(
        attributes=kinds.Attributes(POSITION=0, COLOR_0=1),
        indices=2,
        mode=kinds.LINE_STRIP,
        material=0,
        targets=[kinds.Attributes(POSITION=0), kinds.Attributes(NORMAL=0)],
        extras={
            "label": "",
            "closed": False,
            "nothing": [],
            "deep": {"empty": {}, "full": [1, [], {"a": None, "b": 2}]},
        },
    )
    sampler = kinds.AnimationSampler(input=0, output=0)
    channel = kinds.AnimationChannel(sampler=0, target=kinds.AnimationChannelTarget(node=0, path="weights"))
    document = document_kind(
        asset=kinds.Asset(generator="ä", extras={"notice": "no"}),
        scene=0,
        scenes=[kinds.Scene(nodes=[0])],
        nodes=[kinds.Node(name="a", mesh=0, children=[1], translation=[0.0, -0.5, 1e-9]), kinds.Node(name="b", skin=0)],
        meshes=[kinds.Mesh(name="m", primitives=[primitive], extras={"targetNames": ["x"]})],
        materials=[ink, kinds.Material(name="plain")],
        accessors=[kinds.Accessor(bufferView=0, componentType=kinds.FLOAT, count=3, type="VEC3", min=[0.1], max=[2.5])],
        bufferViews=[kinds.BufferView(buffer=0, byteLength=36, target=kinds.ARRAY_BUFFER)],
        buffers=[kinds.Buffer(byteLength=36, uri="x.bin")],
        images=[kinds.Image(mimeType="image/png", bufferView=0)],
        samplers=[kinds.Sampler(magFilter=kinds.LINEAR, minFilter=kinds.LINEAR_MIPMAP_LINEAR)],
        textures=[kinds.Texture(sampler=0, source=0)],
        skins=[kinds.Skin(name="s", joints=[1], skeleton=1, inverseBindMatrices=0)],
        animations=[kinds.Animation(name="r", channels=[channel], samplers=[sampler])],
        extensionsUsed=["KHR_materials_unlit"],
    )
    return document


def test_the_json_is_that_of_the_library() -> None:
    library = whole(pygltflib, pygltflib.GLTF2)
    text = ours.json_of(whole(ours, ours.Document)).decode()
    assert text == library.gltf_to_json(separators=(",", ":"), indent=None)


def test_an_empty_document_too() -> None:
    asset = {"generator": "nobody"}
    library = pygltflib.GLTF2(asset=pygltflib.Asset(**asset)).gltf_to_json(separators=(",", ":"), indent=None)
    assert ours.json_of(ours.Document(asset=ours.Asset(**asset))) == library.encode()


def test_a_nodes_weights_are_written() -> None:
    document = ours.Document(nodes=[ours.Node(name="a", weights=[0.0, 0.5])])
    assert json.loads(ours.json_of(document))["nodes"] == [{"name": "a", "weights": [0.0, 0.5]}]


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        ours.json_of(ours.Document(nodes=[ours.Node(name="a", scale=[float("nan"), 1.0, 1.0])]))
