"""The unknowns of a fit by name: what can be locked, and how a posterior is laid out.

BONE.rotation, BONE.translation, BONE.scale   three of a bone's nine; BONE: all nine
SHAPE                                         the weight of one blendshape
rotations, translations, scales, shapes       all of a kind
"""

import numpy as np

from breastrig.core.arrays import Integers
from breastrig.core.errors import BadSettings, unknown_name
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS


def shape_block(rig: Rig) -> slice:
    """Places of the shape weights among the (P,) unknowns."""
    first = BONE_DOFS * len(rig.bones)
    return slice(first, first + len(rig.shapes))


PARTS = ("rotation", "translation", "scale")  # of a bone, three numbers each


def blocks(rig: Rig) -> dict[str, slice]:
    """The smallest blocks, in the order of the (P,) unknowns."""
    found = {}
    for j, bone in enumerate(rig.bone_names):
        for k, part in enumerate(PARTS):
            start = BONE_DOFS * j + 3 * k
            found[f"{bone}.{part}"] = slice(start, start + 3)
    first = BONE_DOFS * len(rig.bones)
    return found | {name: slice(first + k, first + k + 1) for k, name in enumerate(rig.shape_names)}


def block(rig: Rig, name: str) -> Integers:
    """Places in the (P,) unknowns; BadSettings for a name that the rig has not."""
    known = blocks(rig)
    kinds = {f"{part}s": [each for each in known if each.endswith(f".{part}")] for part in PARTS}
    kinds["shapes"] = list(rig.shape_names)
    kinds |= {bone: [f"{bone}.{part}" for part in PARTS] for bone in rig.bone_names}
    if name not in known and name not in kinds:
        raise BadSettings(unknown_name("block of this model", name, (*kinds, *known)))
    places = np.arange(BONE_DOFS * len(rig.bones) + len(rig.shapes))
    members = [name] if name in known else kinds[name]
    return np.concatenate([places[:0], *(places[known[each]] for each in members)])
