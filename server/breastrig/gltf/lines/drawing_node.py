"""Adds a drawing to a document that holds the skinned rig: node `drawing_<name>`, one primitive per shape.

The node uses the rig's skin and has the rig's morph targets, so the same pose moves it.  Each primitive's
extras name the shape and keep its surface points' colour; the material is unlit: a pen's line has no shading.
"""

import numpy as np
from pygltflib import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, Mesh, Primitive

from breastrig.core.arrays import Array
from breastrig.core.srgb import rgb
from breastrig.gltf.container import UNLIT, BufferWriter, append, unlit
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.lines.ribbon import Ribbon, exact_in, ribbons
from breastrig.gltf.skinned import SkinnedNodes, as_float32
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose


def drawing_node(name: str) -> str:
    """Name of the node that carries the drawing called `name`."""
    return f"drawing_{name}"


def add_drawing(
    document: Document,
    buffer: BufferWriter,
    skinned: SkinnedNodes,
    rig: Rig,
    drawing: ModelDrawing,
    positions: list[Array],
    positions_buffer: BufferWriter | None = None,
) -> None:
    """Adds the drawing's node; nothing when the drawing has no line.

    `positions` are the rest positions of its ribbons (see `positions_exact_in`); they go into a buffer of their own
    when one is given, because only they depend on the pose.
    """
    lines = ribbons(rig, drawing)
    if not lines:
        return
    places = [add_positions(positions_buffer or buffer, points) for points in positions]
    mesh = Mesh(
        name=drawing_node(drawing.name),
        primitives=[_primitive(document, buffer, line, place) for line, place in zip(lines, places, strict=True)],
        extras={"targetNames": list(rig.shape_names)},
    )
    node = Node(name=mesh.name, mesh=append(document.meshes, mesh), skin=skinned.skin)
    skinned.nodes[mesh.name] = append(document.nodes, node)
    document.scenes[0].nodes.append(skinned.nodes[mesh.name])
    document.extensionsUsed = [UNLIT]


def positions_exact_in(rig: Rig, drawing: ModelDrawing, x: RigParameters) -> list[Array]:
    """Rest positions of the drawing's ribbons, with which they lie on the mesh posed by `x`."""
    return exact_in(rig, ribbons(rig, drawing), x, pose(rig, x))


def add_positions(buffer: BufferWriter, positions: Array) -> int:
    """The accessor of one ribbon's positions."""
    return buffer.add(as_float32(positions), target=ARRAY_BUFFER, bounds=True)


def _primitive(document: Document, buffer: BufferWriter, line: Ribbon, place: int) -> Primitive:
    on_vertices = ARRAY_BUFFER
    attributes = Attributes(
        POSITION=place,
        JOINTS_0=buffer.add(line.joints, target=on_vertices),
        WEIGHTS_0=buffer.add(line.weights, target=on_vertices),
    )
    indices = buffer.add(line.faces.ravel().astype(np.uint32), target=ELEMENT_ARRAY_BUFFER)
    targets = [
        Attributes(POSITION=buffer.add(as_float32(moves), target=on_vertices, bounds=True))
        for moves in line.blendshapes
    ]
    return Primitive(
        attributes=attributes,
        indices=indices,
        material=_ink(document, line.shape.color),
        targets=targets,
        extras={"name": line.shape.name, "label": line.shape.label, "closed": line.shape.closed},
    )


def _ink(document: Document, color: str) -> int:
    """The material of that colour, made once."""
    name = f"ink_{color.lstrip('#').lower()}"
    for index, material in enumerate(document.materials):
        if material.name == name:
            return index
    return append(document.materials, unlit(name, rgb(color), both_sides=True))
