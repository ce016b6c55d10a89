"""Extends pygltflib's classes: weights of nodes, and a document's JSON at once.

A primitive's attributes are a dictionary of accessors by their meaning (POSITION, NORMAL, ...). pygltflib leaves out
fields that are None or empty too, but copies each value several times for it: a tenth of a second for a fit.
"""

import dataclasses
import json
from typing import Any, TypeAlias

import pygltflib

Attributes: TypeAlias = dict[str, int]
Document: TypeAlias = pygltflib.GLTF2


@dataclasses.dataclass
class Node(pygltflib.Node):  # type: ignore[misc]  # a package without types
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
