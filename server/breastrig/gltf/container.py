"""Buffers, views and accessors: numpy arrays in, glTF bytes out.

document.py holds the document; the bytes are laid out here.  One view per accessor, each aligned to four
bytes, no interleaving, no sparse accessors (some viewers flicker with them).  The same input gives the same bytes: no
dates, keys in one order.
"""

import copy
from typing import Any

import numpy as np
from pygltflib import (
    FLOAT,
    UNSIGNED_BYTE,
    UNSIGNED_INT,
    UNSIGNED_SHORT,
    Accessor,
    Asset,
    Buffer,
    BufferView,
    Material,
    PbrMetallicRoughness,
    Scene,
)

from breastrig.core.arrays import Array
from breastrig.core.glb import pack_glb
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.srgb import to_light
from breastrig.core.version import __version__
from breastrig.gltf.document import Document, json_of

UNLIT = "KHR_materials_unlit"
GENERATOR = f"BreastRig {__version__}"
COMPONENT_TYPES = {
    np.dtype(np.uint8): UNSIGNED_BYTE,
    np.dtype(np.uint16): UNSIGNED_SHORT,
    np.dtype(np.uint32): UNSIGNED_INT,
    np.dtype(np.float32): FLOAT,
}
ELEMENT_TYPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}


def new_document(extras: dict[str, Any] | None = None) -> Document:
    """An empty glTF 2.0 document with its generator and the notice of limits of use."""
    document = Document(asset=Asset(generator=GENERATOR, extras={"notice": LIMITS_OF_USE, **(extras or {})}))
    document.scene = 0
    document.scenes = [Scene(nodes=[])]
    return document


def moved_to(place: Array) -> list[float] | None:
    """A node's translation to a (3,) m place; nothing at the origin."""
    return [float(value) for value in place] if place.any() else None


def unlit(name: str, colour: tuple[int, int, int], both_sides: bool = False) -> Material:
    """The unshaded material of a pen's line; red, green, blue of 0 to 255."""
    linear = [round(float(level), 5) for level in to_light(np.array(colour) / 255.0)]
    shading = PbrMetallicRoughness(baseColorFactor=[*linear, 1.0], metallicFactor=0.0, roughnessFactor=1.0)
    return Material(name=name, doubleSided=both_sides, pbrMetallicRoughness=shading, extensions={UNLIT: {}})


def append(items: list[Any], item: Any) -> int:
    """Adds `item` to one of the document's lists and returns its index."""
    items.append(item)
    return len(items) - 1


class BufferWriter:
    """Grows one buffer of a document, accessor by accessor."""

    def __init__(self, document: Document, uri: str | None = None) -> None:
        self._document = document
        self._chunks: list[bytes] = []
        self._length = 0
        self._known: dict[tuple[Any, ...], int] = {}
        self._buffer = append(document.buffers, Buffer(byteLength=0, uri=uri))

    def going_on(self, document: Document) -> "BufferWriter":
        """Another writer with what this one holds, for a copy of its document."""
        other = copy.copy(self)
        other._document, other._chunks, other._known = document, [*self._chunks], {**self._known}
        return other

    def add_bytes(self, data: bytes, target: int | None = None) -> int:
        """Appends raw bytes (padded to four) and returns the index of their buffer view."""
        view = BufferView(buffer=self._buffer, byteOffset=self._length, byteLength=len(data), target=target)
        padded = data + b"\0" * (-len(data) % 4)
        self._chunks.append(padded)
        self._length += len(padded)
        self._document.buffers[self._buffer].byteLength = self._length
        return append(self._document.bufferViews, view)

    def add(
        self, array: np.ndarray[Any, Any], *, target: int | None = None, bounds: bool = False, normalized: bool = False
    ) -> int:
        """Appends (N, ...) uint8, uint16, uint32 or float32 numbers and returns the index of their accessor.

        Equal numbers for the same use share one accessor: many shapes leave a drawing alone.
        """
        data = np.ascontiguousarray(array)
        element = data.shape[1:]
        if element == (4, 4):
            data = np.ascontiguousarray(data.transpose(0, 2, 1))  # glTF stores matrices column by column
        content = data.astype(data.dtype.newbyteorder("<")).tobytes()
        key = (content, data.dtype, data.shape, target, bounds, normalized)
        if key in self._known:
            return self._known[key]
        accessor = Accessor(
            byteOffset=None,  # defaults are left out: an iteration's file has hundreds of accessors
            bufferView=self.add_bytes(content, target),
            componentType=COMPONENT_TYPES[data.dtype],
            count=len(data),
            type=ELEMENT_TYPES[element],
            normalized=normalized or None,
        )
        if bounds:
            columns = np.ascontiguousarray(data.reshape(len(data), -1).T)  # ten times as fast as along them
            accessor.min, accessor.max = _shortest(columns.min(axis=1)), _shortest(columns.max(axis=1))
        self._known[key] = append(self._document.accessors, accessor)
        return self._known[key]

    def content(self) -> bytes:
        """All bytes of the buffer so far."""
        return b"".join(self._chunks)


def _shortest(values: np.ndarray[Any, Any]) -> list[Any]:
    """The numbers with as few digits as name the same float32."""
    return [float(str(value)) if values.dtype == np.float32 else int(value) for value in values]


def to_gltf(document: Document) -> bytes:
    """The document as JSON text, its buffers elsewhere."""
    return json_of(document)


def to_glb(document: Document, buffer: BufferWriter) -> bytes:
    """The document and its only buffer in one .glb."""
    return pack_glb(to_gltf(document), buffer.content())
