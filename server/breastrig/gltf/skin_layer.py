"""The free-form layer of a fit as one more morph target, `skin_layer`, of every mesh in its .glb.

Bones and blendshapes alone cannot show where the layer has moved the skin.  As a target of its own it is on in the
last pose, off in all earlier ones, and whoever opens the file can take it off again.  Moves are those of the rest
position: the inverse of what the last pose's skinning does to them.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.container import BufferWriter
from breastrig.gltf.document import ARRAY_BUFFER, Attributes, Document
from breastrig.gltf.lines.drawing_node import drawing_node
from breastrig.gltf.lines.ribbon import exact_in, inverses, ribbons
from breastrig.gltf.skinned import SkinnedNodes, as_float32, mesh_of
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import Posed

SKIN_LAYER = "skin_layer"


def add_skin_layer(
    document: Document,
    buffer: BufferWriter,
    skinned: SkinnedNodes,
    rig: Rig,
    drawing: ModelDrawing | None,
    x: RigParameters,
    surface: Array,
) -> None:
    """Adds the target, switched on, to the rig's mesh and its drawing's, both posed by `x` (m).

    `surface` (V, 3) m is where the layer has the skin in that pose.
    """
    posed = Posed(rig, x)
    moves = np.einsum("vij,vj->vi", inverses(posed.linear), surface - posed.vertices)
    turns = vertex_normals(posed.shaped + moves, rig.faces) - vertex_normals(posed.shaped, rig.faces)
    on_vertices = ARRAY_BUFFER
    skin = mesh_of(document, skinned, rig.name)
    layer = Attributes(
        POSITION=buffer.add(as_float32(moves), target=on_vertices, bounds=True),
        NORMAL=buffer.add(as_float32(turns), target=on_vertices),
    )
    skin.primitives[0].targets.append(layer)
    skin.extras["targetNames"].append(SKIN_LAYER)
    lines = () if drawing is None else ribbons(rig, drawing)
    if drawing is not None and lines:
        mesh = mesh_of(document, skinned, drawing_node(drawing.name))
        mesh.extras["targetNames"].append(SKIN_LAYER)
        there, before = exact_in(rig, lines, x, surface), exact_in(rig, lines, x, posed.vertices)
        for primitive, at, was in zip(mesh.primitives, there, before, strict=True):
            place = buffer.add(as_float32(at - was), target=on_vertices, bounds=True)
            primitive.targets.append(Attributes(POSITION=place))
    for node in document.nodes:
        if node.mesh is not None:
            node.weights = [*(node.weights or []), 1.0]
