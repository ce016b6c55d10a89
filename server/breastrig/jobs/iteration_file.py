"""One stored iteration as a complete glTF file."""

import json

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import NotFound
from breastrig.geometry.rotations import rotation_from_quaternion
from breastrig.gltf.iterate import iterate_gltf
from breastrig.jobs.events import Iterated
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.storage.events import events_of_kind
from breastrig.storage.fits import FitRow
from breastrig.storage.storage import Storage


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
    """The rig's parameters behind an event: node poses are relative to the parent bone, parameters are absolute."""
    nodes = {node.name: node for node in event.nodes}
    rotations: list[Array] = []
    translations: list[Array] = []
    for bone in rig.bones:
        node = nodes[bone.name]
        rotation = rotation_from_quaternion(np.array(node.rotation))
        translation = np.array(node.translation)
        if bone.parent is not None:  # parents come first
            translation = rotations[bone.parent] @ translation + translations[bone.parent]
            rotation = rotations[bone.parent] @ rotation
        rotations.append(rotation)
        translations.append(translation)
    weights = next(node.weights for node in event.nodes if node.weights is not None)
    return RigParameters(
        rotations=np.array(rotations),
        translations=np.array(translations),
        scales=np.array([nodes[f"{bone.name}_scale"].scale for bone in rig.bones]),
        weights=np.array(weights),
    )
