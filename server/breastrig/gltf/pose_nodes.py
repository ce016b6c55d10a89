"""Rig parameters in glTF's own words: translation, rotation, scale and weights of named nodes.

Bone j's node carries its rotation and translation relative to the parent bone; its leaf child `<bone>_scale`
carries the scale and is the skin's joint, so that no scale is inherited and any set of bone frames is exact:
world(<bone>_scale) = T_j R_j S_j.  The root bone is absolute, in the scan's frame.  The live stream, the
.gltf of an iteration and the animation all speak through this one function.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.rotations import quaternion_from_rotation, rotation_from_quaternion
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import as_linear

DECIMALS = 7  # 0.1 µm and 0.1 µrad: under the float32 accuracy of the vertices


def scale_node(bone: str) -> str:
    """Name of the leaf node that carries the scale of `bone`."""
    return f"{bone}_scale"


def node_poses(rig: Rig, x: RigParameters) -> list[dict[str, Any]]:
    """One dictionary per node: name and those of translation (m), rotation (x y z w), scale, weights it has.

    Weights are those of the shapes, then of correctives.
    """
    rig, x = as_linear(rig, x)
    rotations, translations = x.rotations, x.translations
    children = [index for index, bone in enumerate(rig.bones) if bone.parent is not None]
    if children:
        parents = [bone.parent for bone in rig.bones if bone.parent is not None]
        back = x.rotations[parents].transpose(0, 2, 1)
        rotations, translations = rotations.copy(), translations.copy()
        rotations[children] = back @ x.rotations[children]
        moved = x.translations[children] - x.translations[parents]
        translations[children] = np.einsum("bij,bj->bi", back, moved)
    turned = _rounded(quaternion_from_rotation(rotations))
    poses: list[dict[str, Any]] = []
    parts = zip(rig.bones, _rounded(translations), turned, _rounded(x.scales), strict=True)
    for bone, translation, rotation, scale in parts:
        poses.append({"name": bone.name, "translation": translation, "rotation": rotation})
        poses.append({"name": scale_node(bone.name), "scale": scale})
    poses.append({"name": rig.name, "weights": _rounded(x.weights)})
    return poses


def posed_by_nodes(rig: Rig, poses: Iterable[Mapping[str, Any]], modes: Sequence[float] = ()) -> RigParameters:
    """The parameters behind `node_poses`, which are relative to the parent bone, with weights of smooth modes."""
    nodes = {pose["name"]: pose for pose in poses}
    rotations: list[Array] = []
    translations: list[Array] = []
    for bone in rig.bones:
        node = nodes[bone.name]
        rotation = rotation_from_quaternion(np.array(node["rotation"]))
        translation = np.array(node["translation"])
        if bone.parent is not None:  # parents come first
            translation = rotations[bone.parent] @ translation + translations[bone.parent]
            rotation = rotations[bone.parent] @ rotation
        rotations.append(rotation)
        translations.append(translation)
    return RigParameters(
        rotations=np.array(rotations),
        translations=np.array(translations),
        scales=np.array([nodes[scale_node(bone.name)]["scale"] for bone in rig.bones]),
        weights=np.array(nodes[rig.name]["weights"][: len(rig.shapes)]),
        modes=np.array(modes, dtype=np.float64),
    )


def _rounded(values: Array) -> list[Any]:
    """Plain floats with seven decimals; no negative zero, which would make equal poses differ in bytes."""
    rounded: list[Any] = (np.round(values, DECIMALS) + 0.0).tolist()
    return rounded
