"""Places on the breast by the clock: an hour and a distance from the nipple.

The clock is read by an observer facing the patient: 12 is towards the patient's head and 3 towards the patient's LEFT,
for both breasts; so 3 is lateral on the left breast and medial on the right one. The distance is measured with a tape
on the skin. The clock's face is the plane of the circle at that distance (its vector area), which follows a breast that
points sideways or down.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadDrawing
from breastrig.core.lru_cache import LruCache
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.polyline import arc_lengths
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama

ROUND = 48  # points of a drawn circle: its chords are off by 0.2 % of the radius
KEPT_CONSTRUCTIONS = 4  # the pattern that a drag began with, and the last ones that it became
SAME = 1e-12  # m: radii that differ by less are one circle, of which each costs some milliseconds
NO_DIRECTION = 1e-4  # m from the centre, under which a place has no hour


Construction = TypeVar("Construction")


@dataclass(frozen=True, eq=False)
class FittedSkin:
    """The rig's skin as it lies on one patient; (V, 3) m in any frame."""

    rig: Rig
    vertices: Array
    known: Mapping[str, Array] = field(default_factory=dict)  # (3,) landmarks that are known better than the model's

    @cached_property
    def _constructions(self) -> LruCache[Hashable, Any]:
        return LruCache(KEPT_CONSTRUCTIONS)

    def constructed(self, pattern: Hashable, construct: Callable[["FittedSkin"], Construction]) -> Construction:
        """The construction of a pattern on this skin, cached: its lines and its handles share it."""
        found: Construction | None = self._constructions.get(pattern)
        if found is None:
            found = construct(self)
            self._constructions.put(pattern, found)
        return found

    @cached_property
    def geodesics(self) -> Geodesics:
        return Geodesics(self.vertices, self.rig.faces)

    @cached_property
    def _search(self) -> ClosestPointSearch:
        return ClosestPointSearch(self.vertices, self.rig.faces)

    def nearest(self, points: Array) -> SurfacePoints:
        """The skin's closest points to (M, 3) m points."""
        return self._search.query(points).on_mesh

    def at(self, points: SurfacePoints) -> Array:
        """(M, 3) m"""
        return points.positions(self.vertices, self.rig.faces)

    def landmark(self, name: str) -> SurfacePoints:
        """BadDrawing when the rig has none of that name."""
        if name not in self.rig.landmark_names:
            raise BadDrawing(f"This drawing starts from the landmark {name}, which this model does not have.")
        if name in self.known:
            return self.nearest(self.known[name][None])
        return self.rig.landmark_points((name,))

    def height(self, name: str) -> float:
        """Height (m) along the body of a landmark itself: a fold under the breast lies beside the fitted skin."""
        place = self.known.get(name)
        return float((self.at(self.landmark(name))[0] if place is None else place) @ self.axes[:, 1])

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
    along = arc_lengths(at)
    whole = along[-1] + np.linalg.norm(at[0] - at[-1])
    chosen = np.unique(np.searchsorted(along, np.arange(ROUND) * whole / ROUND).clip(0, len(at) - 1))
    return rim[chosen]


def angle_of(hour: float) -> float:
    """rad clockwise from 12 for the observer."""
    return float(np.radians(30.0 * hour))


def on_clock(skin: FittedSkin, centre: SurfacePoints, distance: float | Array, angles: Array) -> SurfacePoints:
    """Points at `distance` (m) along the skin from a surface point, under (A,) angles (rad, clockwise from 12).

    The distance is one number or (A,), one for each angle.  BadDrawing when the skin ends before.
    """
    radii, which = _different(np.broadcast_to(np.asarray(distance, dtype=np.float64), angles.shape))
    places = np.zeros((len(angles), 3))
    for number, radius in enumerate(radii):
        here = np.flatnonzero(which == number)
        places[here] = _seen_on_circle(skin, centre, float(radius), angles[here])
    return skin.nearest(places)


def clock_place(skin: FittedSkin, centre: SurfacePoints, place: SurfacePoints) -> tuple[float, float]:
    """(m along the skin, rad clockwise from 12) of a surface point as seen from another: the inverse of `on_clock`.

    BadDrawing when the skin ends nearer than the place.
    """
    distance = skin.geodesics.distance(centre, place)
    if distance < NO_DIRECTION:
        return distance, 0.0
    rim, middle = _circle(skin, centre, distance)
    arm = skin.at(place)[0] - middle
    return distance, float(_seen(skin, rim - middle, arm[None])[0])


def _different(values: Array) -> tuple[Array, Integers]:
    """Numbers that differ by more than rounding, and for each of the (A,) values which it is."""
    _, first, which = np.unique(np.round(values / SAME), return_index=True, return_inverse=True)
    return values[first], which.reshape(values.shape)


def _circle(skin: FittedSkin, centre: SurfacePoints, radius: float) -> tuple[Array, Array]:
    """(M, 3) m of the rim and (3,) m of its centre."""
    circle = skin.geodesics.circle_points(int(centre.faces[0]), centre.barycentric[0], radius)
    return skin.at(circle), skin.at(centre)[0]


def _seen(skin: FittedSkin, arms: Array, directions: Array) -> Array:
    """(D,) rad clockwise from 12, of (D, 3) directions on the clock's face of a circle with (M, 3) m arms."""
    three, twelve = face_of(skin, arms)
    return np.asarray(np.arctan2(directions @ three, directions @ twelve))


def face_of(skin: FittedSkin, arms: Array) -> tuple[Array, Array]:
    """(3,) unit directions of 3 and 12 o'clock on the clock's face of a circle with (M, 3) m arms."""
    facing = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    facing /= np.linalg.norm(facing)
    up = skin.axes[:, 1] - (skin.axes[:, 1] @ facing) * facing
    up /= np.linalg.norm(up)
    return np.cross(up, facing), up


def _seen_on_circle(skin: FittedSkin, centre: SurfacePoints, radius: float, angles: Array) -> Array:
    """(A, 3) m"""
    rim, middle = _circle(skin, centre, radius)
    arms = rim - middle
    gaps = np.angle(np.exp(1j * (_seen(skin, arms, arms) - angles[:, None])))
    after = np.roll(gaps, -1, axis=1)
    crossing = (np.sign(gaps) != np.sign(after)) & (np.abs(gaps - after) < np.pi)
    if not crossing.any(axis=1).all():
        raise BadDrawing("The skin is folded here and shows no such direction; choose another place or check the fit.")
    # where the rim crosses that direction more than once, the outermost crossing is the one that is seen
    k = np.where(crossing, np.linalg.norm(arms, axis=1), -1.0).argmax(axis=1)
    rows = np.arange(len(angles))
    share = (gaps[rows, k] / (gaps[rows, k] - after[rows, k]))[:, None]
    return np.asarray((1.0 - share) * rim[k] + share * np.roll(rim, -1, axis=0)[k])
