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
from breastrig.gltf.drawing_node import drawing_node
from breastrig.gltf.ribbon import exact_in, ribbons
from breastrig.gltf.skinned import SkinnedNodes, as_float32
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
    moves = np.einsum("vij,vj->vi", np.linalg.pinv(posed.linear), surface - posed.vertices)
    turns = vertex_normals(posed.shaped + moves, rig.faces) - vertex_normals(posed.shaped, rig.faces)
    on_vertices = ARRAY_BUFFER
    skin = document.meshes[document.nodes[skinned.nodes[rig.name]].mesh]
    layer = Attributes(
        POSITION=buffer.add(as_float32(moves), target=on_vertices, bounds=True),
        NORMAL=buffer.add(as_float32(turns), target=on_vertices),
    )
    skin.primitives[0].targets.append(layer)
    skin.extras["targetNames"].append(SKIN_LAYER)
    lines = () if drawing is None else ribbons(rig, drawing)
    if drawing is not None and lines:
        mesh = document.meshes[document.nodes[skinned.nodes[drawing_node(drawing.name)]].mesh]
        mesh.extras["targetNames"].append(SKIN_LAYER)
        for primitive, line in zip(mesh.primitives, lines, strict=True):
            change = exact_in(rig, line, x, surface) - exact_in(rig, line, x, posed.vertices)
            place = buffer.add(as_float32(change), target=on_vertices, bounds=True)
            primitive.targets.append(Attributes(POSITION=place))
    for node in document.nodes:
        if node.mesh is not None:
            node.weights = [*node.weights, 1.0]
