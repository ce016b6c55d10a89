"""Places on the breast as surgeons say them: an hour and a distance from the nipple.

The clock is read by an observer who faces the patient: 12 is towards her head and 3 towards her
LEFT, for both breasts; so 3 is lateral on the left breast and medial on the right one.  The distance is that of a
tape on the skin.  The clock's face is the plane that the circle of that distance looks at best (its vector area),
which follows a breast that points sideways or down.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama

ROUND = 48  # points of a drawn circle: its chords are off by 0.2 % of the radius
SIDES = {"L": "left", "R": "right"}


@dataclass(frozen=True, eq=False)
class FittedSkin:
    """The rig's skin as it lies on one patient; (V, 3) m in any frame."""

    rig: Rig
    vertices: Array

    @cached_property
    def geodesics(self) -> Geodesics:
        return Geodesics(self.vertices, self.rig.faces)

    @cached_property
    def _search(self) -> ClosestPointSearch:
        return ClosestPointSearch(self.vertices, self.rig.faces)

    def nearest(self, points: Array) -> SurfacePoints:
        """The skin's closest points to (M, 3) m points."""
        found = self._search.query(points)
        return SurfacePoints(found.faces, found.barycentric)

    def at(self, points: SurfacePoints) -> Array:
        """(M, 3) m"""
        return points.positions(self.vertices, self.rig.faces)

    def landmark(self, name: str) -> SurfacePoints:
        """BadDrawing when the rig has none of that name."""
        if name not in self.rig.landmark_names:
            raise BadDrawing(f"This drawing starts from the landmark {name}, which this model does not have.")
        return self.rig.landmark_points((name,))

    @cached_property
    def axes(self) -> Array:
        """(3, 3): columns are the patient's left, up and front, by all landmarks together."""
        points = self.rig.landmark_points()
        here, rest = self.at(points), points.positions(self.rig.template, self.rig.faces)
        return umeyama(rest, here).rotation


def circle_around(skin: FittedSkin, centre: SurfacePoints, radius: float) -> SurfacePoints:
    """About ROUND points at `radius` (m) along the skin, each exact; BadDrawing when the skin ends before."""
    rim = skin.geodesics.circle_points(int(centre.faces[0]), centre.barycentric[0], radius)
    at = skin.at(rim)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=1))])
    whole = along[-1] + np.linalg.norm(at[0] - at[-1])
    chosen = np.unique(np.searchsorted(along, np.arange(ROUND) * whole / ROUND).clip(0, len(at) - 1))
    return SurfacePoints(rim.faces[chosen], rim.barycentric[chosen])


def angle_of(hour: float) -> float:
    """rad clockwise from 12 for the observer."""
    return float(np.radians(30.0 * hour))


def on_clock(skin: FittedSkin, centre: SurfacePoints, distance: float, angles: Array) -> SurfacePoints:
    """Points at `distance` (m) along the skin from a surface point, under (A,) angles (rad, clockwise from 12).

    BadDrawing when the skin ends before.
    """
    circle = skin.geodesics.circle_points(int(centre.faces[0]), centre.barycentric[0], distance)
    rim, middle = skin.at(circle), skin.at(centre)[0]
    arms = rim - middle
    facing = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    facing /= np.linalg.norm(facing)
    up = skin.axes[:, 1] - (skin.axes[:, 1] @ facing) * facing
    up /= np.linalg.norm(up)
    seen = np.arctan2(arms @ np.cross(up, facing), arms @ up)
    places = np.zeros((len(angles), 3))
    for row, angle in enumerate(angles):
        gaps = np.angle(np.exp(1j * (seen - angle)))
        after = np.roll(gaps, -1)
        crossing = np.flatnonzero((np.sign(gaps) != np.sign(after)) & (np.abs(gaps - after) < np.pi))
        # where the rim crosses that direction more than once, the outermost crossing is the one that is seen
        k = int(crossing[np.linalg.norm(arms[crossing], axis=1).argmax()])
        share = float(gaps[k] / (gaps[k] - after[k]))
        places[row] = (1.0 - share) * rim[k] + share * np.roll(rim, -1, axis=0)[k]
    return skin.nearest(places)
