"""Polylines and balls as .glb: a node for each, in metres as glTF demands, in the frame of the points.

Line strips, not ribbons (ribbon.py): this is for programs that compute with the lines, not for looking.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pygltflib import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, LINE_LOOP, LINE_STRIP, POINTS, Mesh, Primitive

from breastrig.core.arrays import Array
from breastrig.core.single_precision import far_place
from breastrig.gltf.container import UNLIT, BufferWriter, append, moved_to, new_document, to_glb, unlit
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.skinned import as_float32

Colour = tuple[int, int, int]  # red green blue of 0 to 255
NamedLine = tuple[str, Array, bool, Colour]  # name, (M, 3) m, closed


@dataclass(frozen=True, eq=False)
class Ball:
    """A node of its own, with what programs are to know of it."""

    name: str
    center: Array  # (3,) m
    radius: float  # m
    color: Colour
    extras: dict[str, Any]


def lines_glb(lines: Sequence[NamedLine], extras: dict[str, Any] | None = None, balls: Sequence[Ball] = ()) -> bytes:
    """A .glb of these lines and balls."""
    document = new_document(extras)
    buffer = BufferWriter(document)
    if lines or balls:
        document.extensionsUsed = [UNLIT]
    place = far_place(np.concatenate([np.zeros((0, 3)), *(points for _, points, _, _ in lines)]))
    for name, points, is_closed, colour in lines:
        mode = POINTS if len(points) == 1 else LINE_LOOP if is_closed else LINE_STRIP
        primitive = Primitive(
            attributes=Attributes(
                POSITION=buffer.add(as_float32(points - place), target=ARRAY_BUFFER, bounds=True),
            ),
            mode=mode,
            material=append(document.materials, unlit("pen", colour)),
        )
        mesh = append(document.meshes, Mesh(name=name, primitives=[primitive]))
        document.scenes[0].nodes.append(append(document.nodes, Node(name=name, mesh=mesh, translation=moved_to(place))))
    if balls:
        _add_balls(document, buffer, balls)
    return to_glb(document, buffer)


def _add_balls(document: Document, buffer: BufferWriter, balls: Sequence[Ball]) -> None:
    from trimesh.creation import icosphere  # 0.4 s, which lines alone need not wait for

    unit = icosphere(subdivisions=3)
    attributes = Attributes(POSITION=buffer.add(as_float32(unit.vertices), target=ARRAY_BUFFER, bounds=True))
    indices = buffer.add(unit.faces.ravel().astype(np.uint16), target=ELEMENT_ARRAY_BUFFER)
    for ball in balls:
        surface = Primitive(
            attributes=attributes, indices=indices, material=append(document.materials, unlit("pen", ball.color))
        )
        mesh = append(document.meshes, Mesh(name=ball.name, primitives=[surface]))
        place, size = [float(value) for value in ball.center], [ball.radius] * 3
        node = Node(name=ball.name, mesh=mesh, translation=place, scale=size, extras=ball.extras)
        document.scenes[0].nodes.append(append(document.nodes, node))
