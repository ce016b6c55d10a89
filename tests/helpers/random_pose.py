"""Random but plausible parameters of any rig, from a seeded generator; and any rig by another skinning."""

from dataclasses import replace

import numpy as np

from breastrig.rig.model import Corrective, Rig, Skinning
from breastrig.rig.parameters import RigParameters, rest_parameters


def random_parameters(
    rig: Rig,
    rng: np.random.Generator,
    turn: float = 0.3,
    move: float = 0.02,
    scale: float = 0.1,
    shape: float = 0.5,
) -> RigParameters:
    """Rest, moved by independent normal steps: turn in rad, move in m, scale, shape in sigmas of each shape."""
    rest = rest_parameters(rig)
    bones = len(rig.bones)
    step = np.zeros(rest.dof)
    blocks = step[: 9 * bones].reshape(bones, 9)
    blocks[:, 0:3] = turn * rng.normal(size=(bones, 3))
    blocks[:, 3:6] = move * rng.normal(size=(bones, 3))
    blocks[:, 6:9] = scale * rng.uniform(-1, 1, size=(bones, 3))
    step[9 * bones :] = shape * rng.normal(size=len(rig.shapes)) * [s.sigma for s in rig.shapes]
    return rest.retract(step)


def skinned_by(rig: Rig, skinning: Skinning) -> Rig:
    """Where it is "corrective", with two shapes: by a turn about two axes, and by the square of one about the third."""
    if skinning != "corrective":
        return replace(rig, skinning=skinning)
    bulges = 0.02 * np.sin(20.0 * rig.template[:, :, None] + np.arange(2)).transpose(2, 0, 1)
    last = len(rig.joints) - 1
    made = (Corrective("bent", last, (1, 1, 0), bulges[0]), Corrective("raised", last - 1, (0, 0, 2), bulges[1]))
    return replace(rig, skinning=skinning, correctives=made)
