"""One stored iteration as a complete glTF file."""

import json

from breastrig.core.errors import NotFound
from breastrig.gltf.iterate import iterate_gltf
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.storage.rows.events import events_of_kind
from breastrig.storage.rows.fits import FitRow
from breastrig.storage.storage import Storage
from breastrig.workflow.events import Iterated


def iteration_gltf(
    storage: Storage, fit: FitRow, iteration: int, rig: Rig, model_uri: str, drawing_uri: str | None
) -> bytes:
    """The .gltf of that iteration; its buffers are the two given addresses.  Raises NotFound."""
    found = events_of_kind(storage, fit.id, "iterated", offset=iteration) if iteration < 2**31 else []
    event = Iterated.model_validate(json.loads(found[0].json)) if found else None
    if event is None or event.iteration != iteration:
        raise NotFound(f"This fit has no iteration {iteration}; it has {fit.iterations} so far, from 0.")
    drawing = next((one for one in rig.drawings if one.name == fit.drawing), None)
    return iterate_gltf(rig, parameters_of(rig, event), drawing, model_uri, drawing_uri if drawing else None)


def parameters_of(rig: Rig, event: Iterated) -> RigParameters:
    """The rig's parameters of an event."""
    return posed_by_nodes(rig, [node.model_dump() for node in event.nodes])
