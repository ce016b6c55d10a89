"""pygltflib's classes under the names of glTF's specification, the weights that its nodes lack, and its JSON at once.

A primitive's attributes are a dictionary of accessors by what they mean.

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

Attributes: TypeAlias = dict[str, int]  # accessors by what they mean: POSITION, NORMAL, ...
Document: TypeAlias = pygltflib.GLTF2


@dataclasses.dataclass
class Node(pygltflib.Node):  # type: ignore[misc]
    """A node that can carry blendshape weights."""

    weights: list[float] | None = None


def json_of(document: Document) -> bytes:
    """The document, its buffers elsewhere; ValueError for a number that is not finite."""
    return json.dumps(_plain(document), separators=(",", ":"), allow_nan=False).encode()


_LEAVES = frozenset((bool, int, float, str))  # written as they are
_CONTAINERS = frozenset((list, tuple, dict))


def _plain(value: Any) -> Any:
    """Dictionaries and lists without what is None or empty; an extension may be empty."""
    kind = type(value)
    if kind is list:
        return value if value and type(value[-1]) in _LEAVES else [_plain(each) for each in value]
    if kind is dict:
        entries = value
    elif fields := getattr(kind, "__dataclass_fields__", None):
        entries = {name: getattr(value, name) for name in fields}
    else:
        return value
    result = {}
    for name, each in entries.items():
        kind = type(each)
        if kind in _LEAVES:
            if each != "":
                result[name] = each
        elif each is not None and (each or kind not in _CONTAINERS):
            result[name] = each if name == "extensions" else _plain(each)
    return result
