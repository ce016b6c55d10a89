"""The body's own directions in a scan's frame, as programs see them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from breastrig.core.arrays import Array, frozen
from breastrig.report.body_frame import body_frame
from breastrig.rig.model import Rig


@dataclass(frozen=True, eq=False)
class Frame:
    """The patient's left, up and front by the fitted trunk: unit vectors (3,) in the scan's frame, right-handed.

    `origin` (3,), in the scan's unit, lies in the median plane.
    """

    origin: Array
    left: Array
    up: Array  # to the head
    front: Array

    def to_body(self, points: ArrayLike) -> Array:
        """(..., 3) how far points (..., 3) of the scan's frame are to the left, up and in front of the origin."""
        axes = np.stack([self.left, self.up, self.front], axis=1)
        return np.asarray((np.asarray(points, dtype=np.float64) - self.origin) @ axes)

    def mirrored(self, points: ArrayLike) -> Array:
        """(..., 3) the mirror images of points (..., 3) on the other side of the median plane."""
        given = np.asarray(points, dtype=np.float64)
        return np.asarray(given - 2.0 * ((given - self.origin) @ self.left)[..., None] * self.left)


def frame_of(rig: Rig, vertices: Array, metres_per_unit: float) -> Frame:
    """The frame of (V, 3) m fitted vertices; its origin is in the scan's unit."""
    found = body_frame(rig, vertices)
    left, up, front = (frozen(axis) for axis in found.axes.T)
    return Frame(frozen(found.middle / metres_per_unit), left, up, front)
