"""One iteration of a fit as a complete glTF file."""

from breastrig.gltf.iterate import iterate_gltf
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.workflow.events import Iterated


def iteration_gltf(event: Iterated, rig: Rig, drawing: str | None, model_uri: str, drawing_uri: str | None) -> bytes:
    """The .gltf of the event's pose with that drawing of the rig; its buffers are the two given addresses."""
    shown = next((one for one in rig.drawings if one.name == drawing), None)
    return iterate_gltf(rig, parameters_of(rig, event), shown, model_uri, drawing_uri if shown else None)


def parameters_of(rig: Rig, event: Iterated) -> RigParameters:
    """The rig's parameters of an event."""
    return posed_by_nodes(rig, [node.model_dump() for node in event.nodes])
