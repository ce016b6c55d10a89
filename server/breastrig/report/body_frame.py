"""The patient's own left, up and front, and the median plane, from the fitted model.

The model is symmetric, so the rigid motion that moves its trunk onto the patient's moves its median plane too. Breasts
and arms are left out: they differ between the sides and hang or lie as gravity says.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama

NOT_TRUNK = ("arm", "breast", "areola")  # beginnings of the names of regions


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """Directions of one patient."""

    axes: Array  # (3, 3), columns: the patient's left, up and front; unit, right-handed
    middle: Array  # (3,) m, a point of the median plane

    def lateral(self, points: Array) -> Array:
        """(...,) m: distance from the median plane to the patient's left."""
        return np.asarray((points - self.middle) @ self.axes[:, 0])

    def on_plane(self, points: Array) -> Array:
        """(..., 3) m: the nearest points of the median plane."""
        return np.asarray(points - self.lateral(points)[..., None] * self.axes[:, 0])

    def height(self, points: Array) -> Array:
        """(...,) m: position along the axis towards the head."""
        return np.asarray((points - self.middle) @ self.axes[:, 1])


def trunk(rig: Rig) -> Integers:
    """The vertices that are neither arm nor breast; all of a rig that has no others."""
    kept = np.ones(len(rig.template), dtype=np.bool_)
    for name, members in rig.regions.items():
        if name.startswith(NOT_TRUNK):
            kept[members] = False
    kept &= kept[rig.mirror_vertices]
    return np.flatnonzero(kept if kept.any() else np.ones_like(kept))


def body_frame(rig: Rig, vertices: Array) -> BodyFrame:
    """The frame of (V, 3) m fitted vertices."""
    chosen = trunk(rig)
    rest, here = rig.template[chosen], vertices[chosen]
    return BodyFrame(umeyama(rest, here).rotation, 0.5 * (here + vertices[rig.mirror_vertices[chosen]]).mean(axis=0))
