"""One iteration of a fit as a complete glTF that owns almost no geometry.

The .gltf is JSON whose buffers point at the immutable model buffer (the binary chunk of the model's .glb) and
at the drawing's buffer; from iteration to iteration only the nodes differ, and the rest positions of the
drawing's ribbons, a few kilobytes that lie in the file itself and make the drawing exact in this pose (see
ribbon.py).  The document is built once for each rig and drawing.
"""

import base64
import copy
from dataclasses import replace
from functools import lru_cache

from breastrig.gltf.container import BufferWriter, new_document, to_gltf
from breastrig.gltf.document import Document
from breastrig.gltf.lines.drawing_node import add_drawing, add_positions, drawing_node, positions_exact_in
from breastrig.gltf.lines.ribbon import ribbons
from breastrig.gltf.replay import add_skin_layers
from breastrig.gltf.skinned import SkinnedNodes, add_skinned_rig, mesh_of, own_targets, set_pose
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import as_linear, pose


def model_buffer(rig: Rig) -> bytes:
    """The immutable buffer of the rig, the same bytes as the binary chunk of its .glb."""
    return _built(rig.with_correctives_as_shapes, None)[2].content()


def drawing_buffer(rig: Rig, drawing: ModelDrawing) -> bytes:
    """The immutable buffer of one of its drawings; empty when the drawing has no line."""
    lines = _built(rig.with_correctives_as_shapes, drawing)[3]
    return b"" if lines is None else lines.content()


def iterate_gltf(
    rig: Rig, x: RigParameters, drawing: ModelDrawing | None, model_uri: str, drawing_uri: str | None
) -> bytes:
    """A complete .gltf of the rig posed by `x` (scan frame, m), its drawing included.

    The buffers are `model_uri` and `drawing_uri`, which must answer with `model_buffer` and `drawing_buffer`;
    a drawing without an address is left out.
    """
    surface = pose(rig, x) if len(x.modes) else None
    rig, x = as_linear(rig, x.without_modes)
    base, skinned, _, lines = _built(rig, drawing if drawing_uri else None)
    document = copy.copy(base)
    document.nodes = copy.deepcopy(base.nodes)
    document.buffers = copy.deepcopy(base.buffers)
    document.buffers[0].uri = model_uri
    if drawing is not None and lines is not None:
        document.buffers[1].uri = drawing_uri
        _make_exact(document, skinned, rig, drawing, x)
    set_pose(document, skinned, rig, x)
    if rig.skinning != "linear" or surface is not None:
        document.accessors, document.bufferViews = [*document.accessors], [*document.bufferViews]
        document.meshes = [own_targets(mesh) for mesh in document.meshes]
        layer = BufferWriter(document)
        add_skin_layers(
            document,
            layer,
            skinned,
            rig,
            drawing if lines else None,
            [x],
            [pose(rig, x) if surface is None else surface],
        )
        document.buffers[-1].uri = _in_the_file(layer)
    return to_gltf(document)


def _make_exact(document: Document, skinned: SkinnedNodes, rig: Rig, drawing: ModelDrawing, x: RigParameters) -> None:
    """Fills the document's last buffer, that of the ribbons' positions, for this pose."""
    fresh = Document()
    writer = BufferWriter(fresh)
    places = [add_positions(writer, positions) for positions in positions_exact_in(rig, drawing, x)]
    mesh = mesh_of(document, skinned, drawing_node(drawing.name))
    document.accessors = list(document.accessors)
    for primitive, place in zip(mesh.primitives, places, strict=True):
        found, bounds = primitive.attributes["POSITION"], fresh.accessors[place]
        document.accessors[found] = replace(document.accessors[found], min=bounds.min, max=bounds.max)
    document.buffers[-1].uri = _in_the_file(writer)


def _in_the_file(writer: BufferWriter) -> str:
    return f"data:application/octet-stream;base64,{base64.b64encode(writer.content()).decode()}"


@lru_cache(maxsize=8)
def _built(rig: Rig, drawing: ModelDrawing | None) -> tuple[Document, SkinnedNodes, BufferWriter, BufferWriter | None]:
    """The document without a pose, its nodes, the model's buffer, the drawing's buffer when it has a line."""
    document = new_document()
    model = BufferWriter(document)
    skinned = add_skinned_rig(document, model, rig)
    rest = [] if drawing is None else [line.positions for line in ribbons(rig, drawing)]
    if drawing is None or not rest:  # glTF forbids empty buffers
        return document, skinned, model, None
    lines = BufferWriter(document)
    add_drawing(document, lines, skinned, rig, drawing, rest, positions_buffer=BufferWriter(document))
    return document, skinned, model, lines
