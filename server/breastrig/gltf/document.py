"""pygltflib's classes under the names of glTF's specification, the weights that its nodes lack, and its JSON at once.

Fields that are None or empty are left out of the JSON, as pygltflib does, which copies each value several times for
it: a tenth of a second for a fit.
"""

import dataclasses
import json
from typing import Any, TypeAlias

import pygltflib
from pygltflib import (
    ARRAY_BUFFER,
    ELEMENT_ARRAY_BUFFER,
    FLOAT,
    LINE_LOOP,
    LINE_STRIP,
    LINEAR,
    LINEAR_MIPMAP_LINEAR,
    POINTS,
    UNSIGNED_BYTE,
    UNSIGNED_INT,
    UNSIGNED_SHORT,
    Accessor,
    Animation,
    AnimationChannel,
    AnimationChannelTarget,
    AnimationSampler,
    Asset,
    Attributes,
    Buffer,
    BufferView,
    Image,
    Material,
    Mesh,
    PbrMetallicRoughness,
    Primitive,
    Sampler,
    Scene,
    Skin,
    Texture,
    TextureInfo,
)

__all__ = [
    "ARRAY_BUFFER",
    "ELEMENT_ARRAY_BUFFER",
    "FLOAT",
    "LINEAR",
    "LINEAR_MIPMAP_LINEAR",
    "LINE_LOOP",
    "LINE_STRIP",
    "POINTS",
    "UNSIGNED_BYTE",
    "UNSIGNED_INT",
    "UNSIGNED_SHORT",
    "Accessor",
    "Animation",
    "AnimationChannel",
    "AnimationChannelTarget",
    "AnimationSampler",
    "Asset",
    "Attributes",
    "Buffer",
    "BufferView",
    "Document",
    "Image",
    "Material",
    "Mesh",
    "Node",
    "PbrMetallicRoughness",
    "Primitive",
    "Sampler",
    "Scene",
    "Skin",
    "Texture",
    "TextureInfo",
    "json_of",
]

Document: TypeAlias = pygltflib.GLTF2


@dataclasses.dataclass
class Node(pygltflib.Node):  # type: ignore[misc]
    """A node that can carry blendshape weights."""

    weights: list[float] | None = None


def json_of(document: Document) -> bytes:
    """The document, its buffers elsewhere; ValueError for a number that is not finite."""
    return json.dumps(_plain(document), separators=(",", ":"), allow_nan=False).encode()


def _plain(value: Any) -> Any:
    """Dictionaries and lists without what is None or empty; an extension may be empty."""
    if isinstance(value, list):
        return value if value and isinstance(value[-1], int | float) else [_plain(each) for each in value]
    if isinstance(value, Attributes):
        entries = vars(value)  # they take any name
    elif isinstance(value, dict):
        entries = value
    elif dataclasses.is_dataclass(value):
        entries = {name: getattr(value, name) for name in value.__dataclass_fields__}
    else:
        return value
    return {
        name: each if name == "extensions" else _plain(each)
        for name, each in entries.items()
        if each is not None and not (isinstance(each, str | list | tuple | dict) and not each)
    }
