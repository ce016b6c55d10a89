"""Priors of shapes and joints in one stance, where it differs from the rig's own: data beside the rig.

Bodies in a breast MRI hang farther than any other and hold their arms overhead (docs/decisions/0019).
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from pydantic import Field, FiniteFloat

from breastrig.core.arrays import Array
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import split_side
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

MIRRORED = np.array([1.0, -1.0, -1.0])  # of a rotation vector, in the median plane


class ShapePrior(SettingsPart):
    """The prior of one shape's weight; absent values are the rig's."""

    min: FiniteFloat | None = None
    max: FiniteFloat | None = None
    sigma: Positive | None = None
    mean: FiniteFloat = 0.0


class JointPrior(SettingsPart):
    """The prior of the joint above one bone; absent: the rig's, and no rotation."""

    rotation_sigma: Positive | None = None  # rad
    rotation_limit: Positive | None = None  # rad
    rest: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)  # rad, rotation vector of the left side


class StancePriors(SettingsPart):
    """Priors by the names of shapes and bones without their sides."""

    shapes: dict[str, ShapePrior] = Field(default={})
    joints: dict[str, JointPrior] = Field(default={})


@lru_cache(maxsize=16)
def stance_priors(rig: Rig, stance: str) -> StancePriors:
    """The stance's priors; empty where nothing differs."""
    return known_part(rig, f"priors_{stance}.toml", StancePriors) or StancePriors()


@lru_cache(maxsize=16)
def in_stance(rig: Rig, stance: str) -> Rig:
    """The rig with the limits and expected sizes of its shapes and joints in this stance; itself where none differs."""
    priors = stance_priors(rig, stance)
    if not priors.shapes and not priors.joints:
        return rig
    shapes = tuple(
        replace(shape, **priors.shapes[stem].model_dump(exclude={"mean"}, exclude_none=True))
        if (stem := split_side(shape.name)[0]) in priors.shapes
        else shape
        for shape in rig.shapes
    )
    joints = tuple(
        replace(joint, **prior.model_dump(exclude={"rest"}, exclude_none=True))
        if (prior := priors.joints.get(split_side(rig.bone_names[joint.child])[0]))
        else joint
        for joint in rig.joints
    )
    return replace(rig, shapes=shapes, joints=joints)


def mean_weights(rig: Rig, stance: str) -> Array:
    """(S,) expected weights of the shapes in this stance."""
    known = stance_priors(rig, stance).shapes
    return np.array([known[stem].mean if (stem := split_side(n)[0]) in known else 0.0 for n in rig.shape_names])


def rest_turns(rig: Rig, stance: str) -> Array | None:
    """(J, 3) rad, rotation vectors of the joints in the stance's rest pose; None where it is the rig's."""
    known = stance_priors(rig, stance).joints
    if not any(any(prior.rest) for prior in known.values()):
        return None
    turns = np.zeros((len(rig.joints), 3))
    for turn, joint in zip(turns, rig.joints, strict=True):
        stem, side = split_side(rig.bone_names[joint.child])
        if stem in known:
            turn += np.array(known[stem].rest) * (MIRRORED if side == "R" else 1.0)
    return turns
