"""One iteration of a fit as a complete glTF that owns no geometry.

The .gltf is JSON whose buffers point at the immutable model buffer (the binary chunk of the model's .glb) and
at the drawing's buffer; only the nodes differ from iteration to iteration.  The document is built once for
each rig and drawing.
"""

import copy
from functools import lru_cache

from pygltflib import GLTF2

from breastrig.gltf.container import BufferWriter, new_document, to_gltf
from breastrig.gltf.drawing_node import add_drawing
from breastrig.gltf.skinned import SkinnedNodes, add_skinned_rig, set_pose
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters


def model_buffer(rig: Rig) -> bytes:
    """The immutable buffer of the rig, the same bytes as the binary chunk of its .glb."""
    return _built(rig, None)[2].content()


def drawing_buffer(rig: Rig, drawing: ModelDrawing) -> bytes:
    """The immutable buffer of one of its drawings; empty when the drawing has no line."""
    lines = _built(rig, drawing)[3]
    return b"" if lines is None else lines.content()


def iterate_gltf(
    rig: Rig, x: RigParameters, drawing: ModelDrawing | None, model_uri: str, drawing_uri: str | None
) -> bytes:
    """A complete .gltf of the rig posed by `x` (scan frame, m), its drawing included.

    The buffers are `model_uri` and `drawing_uri`, which must answer with `model_buffer` and `drawing_buffer`;
    a drawing without an address is left out.
    """
    base, skinned, _, lines = _built(rig, drawing if drawing_uri else None)
    document = copy.copy(base)
    document.nodes = copy.deepcopy(base.nodes)
    document.buffers = copy.deepcopy(base.buffers)
    document.buffers[0].uri = model_uri
    if lines is not None:
        document.buffers[1].uri = drawing_uri
    set_pose(document, skinned, rig, x)
    return to_gltf(document)


@lru_cache(maxsize=8)
def _built(rig: Rig, drawing: ModelDrawing | None) -> tuple[GLTF2, SkinnedNodes, BufferWriter, BufferWriter | None]:
    """The document without a pose, its nodes, the model's buffer, the drawing's buffer when it has a line."""
    document = new_document()
    model = BufferWriter(document)
    skinned = add_skinned_rig(document, model, rig)
    if drawing is None:
        return document, skinned, model, None
    lines = BufferWriter(document)
    add_drawing(document, lines, skinned, rig, drawing)
    if not lines.content():  # glTF forbids empty buffers
        document.buffers.pop()
        return document, skinned, model, None
    return document, skinned, model, lines
