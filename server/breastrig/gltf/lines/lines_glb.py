"""Polylines as .glb: one node and one line strip for each, in metres as glTF demands, in the frame of the points.

Line strips, not ribbons (ribbon.py): this is for programs that compute with the lines, not for looking.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.single_precision import far_place
from breastrig.gltf.container import BufferWriter, append, moved_to, new_document, to_glb
from breastrig.gltf.document import (
    ARRAY_BUFFER,
    LINE_LOOP,
    LINE_STRIP,
    POINTS,
    Attributes,
    Document,
    Material,
    Mesh,
    Node,
    PbrMetallicRoughness,
    Primitive,
)
from breastrig.gltf.skinned import as_float32

UNLIT = "KHR_materials_unlit"


def lines_glb(
    lines: Sequence[tuple[str, Array, bool, tuple[int, int, int]]], extras: dict[str, Any] | None = None
) -> bytes:
    """A .glb of (name, (M, 3) m points, closed, red green blue of 0 to 255)."""
    document = new_document(extras)
    buffer = BufferWriter(document)
    if lines:
        document.extensionsUsed = [UNLIT]
    place = far_place(np.concatenate([np.zeros((0, 3)), *(points for _, points, _, _ in lines)]))
    for name, points, is_closed, colour in lines:
        mode = POINTS if len(points) == 1 else LINE_LOOP if is_closed else LINE_STRIP
        primitive = Primitive(
            attributes=Attributes(
                POSITION=buffer.add(as_float32(points - place), target=ARRAY_BUFFER, bounds=True),
            ),
            mode=mode,
            material=_pen(document, colour),
        )
        mesh = append(document.meshes, Mesh(name=name, primitives=[primitive]))
        document.scenes[0].nodes.append(append(document.nodes, Node(name=name, mesh=mesh, translation=moved_to(place))))
    return to_glb(document, buffer)


def _pen(document: Document, colour: tuple[int, int, int]) -> int:
    light = [
        level / 12.92 if level <= 0.04045 else ((level + 0.055) / 1.055) ** 2.4 for level in (c / 255 for c in colour)
    ]
    material = Material(
        name="pen",
        pbrMetallicRoughness=PbrMetallicRoughness(
            baseColorFactor=[*(round(level, 5) for level in light), 1.0], metallicFactor=0.0, roughnessFactor=1.0
        ),
        extensions={UNLIT: {}},
    )
    return append(document.materials, material)
