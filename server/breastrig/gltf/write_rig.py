"""Rig -> torso.glb.  The same rig gives the same bytes."""

from breastrig.gltf.container import BufferWriter, new_document, to_glb
from breastrig.gltf.skinned import add_skinned_rig, set_pose
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters

GENERATOR = "BreastRig"  # without a version: the hash of a rig covers it, and is the same whatever version writes it


def rig_glb(rig: Rig, generator: str = GENERATOR) -> bytes:
    """The rig at rest as one .glb."""
    document = new_document()
    document.asset.generator = generator
    buffer = BufferWriter(document)
    rig = rig.with_correctives_as_shapes
    skinned = add_skinned_rig(document, buffer, rig)
    set_pose(document, skinned, rig, rest_parameters(rig))
    return to_glb(document, buffer)
