"""The tip of a standing shoulder, observed from the form of shoulder and upper arm in the fitted model.

It is where the arm's outer edge a little below is so far out and its front so far in front; both depend on the tip's
height and are iterated.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.relief.limits import Shoulder

ROUNDS = 12  # each goes half of the way, so that a thousandth is left


@dataclass(frozen=True, eq=False)
class ShoulderTip:
    """A shoulder's tip, in the frame of the vertices it was found on (m)."""

    place: Array  # (3,) on the skin
    edge: Array  # (3,) the arm's outer edge
    front: Array  # (3,) the arm's front


def shoulder_tip(vertices: Array, faces: Integers, near: Array, rules: Shoulder) -> ShoulderTip | None:
    """The tip of the shoulder around `near` (3,) m on (V, 3) m `vertices` with (F, 3) triangles.

    The axes are outwards on this side, up and front. None where the skin around has no such form.
    """
    around = faces[(np.linalg.norm(vertices[faces[:, 0]] - near, axis=1) < rules.reach)]
    tip = near
    for _ in range(ROUNDS):
        level = _cut(vertices, around, 1, tip[1] - rules.edge_below)
        if not len(level):
            return None
        edge = level[level[:, 0].argmax()]
        out = edge[0] - rules.edge_beyond
        sagittal = _cut(vertices, around, 0, out)
        below = sagittal[np.abs(sagittal[:, 1] - (tip[1] - rules.front_below)) < rules.strip]
        if not len(below):
            return None
        front = below[below[:, 2].argmax()]
        depth = front[2] - rules.front_before
        above = sagittal[np.abs(sagittal[:, 2] - depth) < rules.strip]
        if not len(above):
            return None
        found = np.array([out, above[:, 1].max(), depth])
        tip = 0.5 * (tip + found)
    if np.linalg.norm(tip - found) > rules.strip or np.linalg.norm(tip - near) > rules.farthest:
        return None
    return ShoulderTip(found, edge, front)


def _cut(vertices: Array, faces: Integers, axis: int, level: float) -> Array:
    """(N, 3) m where the triangles' edges cross the plane in which this coordinate has this value."""
    one, other = vertices[faces].reshape(-1, 3), vertices[np.roll(faces, -1, axis=1)].reshape(-1, 3)
    before, behind = one[:, axis] - level, other[:, axis] - level
    through = np.flatnonzero(before * behind < 0.0)
    share = (before[through] / (before[through] - behind[through]))[:, None]
    return np.asarray((1.0 - share) * one[through] + share * other[through])
