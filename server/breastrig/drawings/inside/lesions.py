"""Lesions inside the body of one scan: depth, distances, slices, outline on the skin.

The error of a transferred lesion is an ellipsoid, flatter along the skin's normal, for the skin next to it is seen.
Distances are straight, from the lesion's centre; the 90 % band of each combines the errors of both ends along it, as
independent. Slices are cuts of the fitted skin.

Evidence: docs/decisions/0015.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.special import chdtri, ndtri

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES, split_side
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.tumour import Tumour
from breastrig.drawings.inks import LESION
from breastrig.drawings.inside.radiology import ClockPosition, RadiologyCheck, checked_radiology, clock_position
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.plan_schema import PlanItem, PlanLesion, PlanTumour, asked_of
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.skin_maps.interior_map import lie_beside, moved_inside
from breastrig.drawings.skin_maps.scan_errors import radii_at
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch, closest_barycentric
from breastrig.geometry.normals import unit_vectors, vertex_normals
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig
from breastrig.rig.near_breasts import near_breasts

Kind = Literal["skin", "nipple", "chest_wall", "line"]

BALL = float(np.sqrt(chdtri(3, 0.1)))  # standard deviations: radius of the ball that holds nine of ten points
LINE = float(ndtri(0.95))  # half of the interval that holds nine of ten numbers
RIM = 48  # points of the outline on the skin
SEEN = 0.01  # m from the fitted skin to the scan; where there is none nearer, the skin is the model's guess
PLANES = {  # columns of the body's axes (left, up, front) that are right and up in the picture, with their signs
    "axial": ((0, 1.0), (2, 1.0)),
    "sagittal": ((2, -1.0), (1, 1.0)),
    "coronal": ((0, 1.0), (1, 1.0)),
}


@dataclass(frozen=True, eq=False)
class Distance:
    """The distance from a lesion's centre to a landmark or line."""

    kind: Kind
    to: str  # name of the landmark or the line
    point: Array  # (3,) m, its nearest one
    length: float  # m
    margin: float | None  # m, half of the band that holds the true length with 90 %; None where that is not known
    is_seen: bool = False  # of the chest wall: whether the scan's file names it there, else it is estimated


@dataclass(frozen=True, eq=False)
class Slice:
    """A plane through the centre of a lesion, with the skin that it cuts."""

    plane: str  # axial | sagittal | coronal
    right: Array  # (3,) unit, in the scan's frame: what is right in the picture; the patient's left or back
    up: Array  # (3,) unit
    outlines: tuple[Array, ...]  # (M, 2) m each, of the skin, from the centre along both
    wall: tuple[Array, ...]  # of the chest wall, where it is known


@dataclass(frozen=True, eq=False)
class PlacedLesion:
    """A lesion in the body of a scan."""

    item: PlanLesion
    center: Array  # (3,) m
    error: float | None  # m, the radius that holds its true centre with 90 %; None where that is not known
    covariance: Array | None  # (3, 3) m², of its centre, in the scan's frame
    depth: float  # m below the fitted skin; negative outside
    is_seen: bool  # whether the scan shows the skin next to it
    distances: tuple[Distance, ...]  # to the skin, the nearer nipple and the chest wall
    slices: tuple[Slice, ...]
    is_carried: bool
    clock: ClockPosition | None = None  # None where the rig has no nipples

    @property
    def radiology(self) -> RadiologyCheck | None:
        """What was typed of a report beside its place; None where nothing was, or there is no clock."""
        if self.clock is None or not self.item.radiology:
            return None
        return checked_radiology(self.item.radiology, self.clock, is_carried=self.is_carried)


class LesionsOnScan:
    """The lesions in one fitted scan; built once, then queried for each."""

    def __init__(self, rig: Rig, scan: FittedScan, wall: Array | None = None) -> None:
        """`wall` (V, 3) m: the chest wall under each vertex, where the rig knows it."""
        self._rig, self._scan = rig, scan
        self._wall = None if wall is None else ClosestPointSearch(wall, rig.faces)
        self._skin = FittedSkin(rig, scan.vertices, scan.known)
        self._settings = skin_map_settings(rig)
        self._normals = vertex_normals(scan.vertices, rig.faces)

    def own(self, items: Iterable[PlanItem]) -> list[PlacedLesion]:
        """The lesions that were given on this scan; a tumour by the clock has the error of the skin there.

        The error of a lesion far from the fitted breasts is unknown, and so are those of its distances.
        """
        return [
            self._placed(item, _center(item), self._radius(_center(item)) if is_by_clock else 0.0)
            for item, is_by_clock in _lesions(self._rig, self._scan, items)
        ]

    def carried(self, other: FittedScan, items: Iterable[PlanItem]) -> list[PlacedLesion]:
        """The lesions that were given on another scan of the same patient."""
        lesions = [item for item, _ in _lesions(self._rig, other, items)]
        if not lesions:
            return []
        there = np.array([_center(item) for item in lesions])
        centers = moved_inside(self._rig, other, self._scan, there)
        nearest = FittedSkin(self._rig, other.vertices, other.known).nearest(there)
        is_known: Booleans = np.any(near_breasts(self._rig)[self._rig.faces[nearest.faces]], axis=1)
        found = carried_errors(self._rig, other, self._scan, there, centers, on_skin=False)
        errors = [None if found is None or not known else float(found[k]) for k, known in enumerate(is_known)]
        return [
            replace(self._placed(item, center, error), is_carried=True)
            for item, center, error in zip(lesions, centers, errors, strict=True)
        ]

    def _placed(self, item: PlanLesion, center: Array, error: float | None) -> PlacedLesion:
        nearest = self._skin.nearest(center[None])
        if not near_breasts(self._rig)[self._rig.faces[nearest.faces]].any():
            error = None
        (skin,) = self._skin.at(nearest)
        (outwards,) = nearest.directions(self._normals, self._rig.faces)
        covariance = None if error is None else self._covariance(error, outwards)
        is_seen = bool(self._scan.target.search.query(skin[None]).distances[0] < SEEN)
        off = self._settings.surface_error if is_seen and self._scan.radii is not None else self._off(skin)
        to_skin = _distance("skin", "skin", skin, center, covariance, off)
        nipples = [
            _distance("nipple", name, place, center, covariance, self._off(place))
            for name in self._rig.landmark_names
            if split_side(name)[0] == "nipple"
            for place in self._skin.at(self._skin.landmark(name))
        ]
        nipples.sort(key=lambda each: each.length)
        walls = self._to_wall(center, covariance)
        return PlacedLesion(
            item,
            center,
            error,
            covariance,
            depth=float(np.copysign(to_skin.length, (skin - center) @ outwards)),
            is_seen=is_seen,
            distances=(to_skin, *nipples[:1], *walls),
            slices=self._slices(center, is_wall_seen=any(each.is_seen for each in walls)),
            is_carried=False,
            clock=self._clock(nipples[0].to, center) if nipples else None,
        )

    def _to_wall(self, center: Array, covariance: Array | None) -> list[Distance]:
        """To the chest wall that is seen, else to the estimated one; none where neither is there."""
        for wall, is_seen in ((self._scan.wall, True), (self._wall, False)):
            if wall is None or (is_seen and lie_beside(wall, center[None])[0]):
                continue
            known = self._settings
            off = known.seen_wall_error if is_seen else known.wall_error.get(self._scan.stance)
            found = _distance("chest_wall", "chest_wall", wall.query(center[None]).points[0], center, covariance, off)
            return [replace(found, is_seen=is_seen)]
        return []

    def _clock(self, nipple: str, center: Array) -> ClockPosition:
        return clock_position(self._skin, self._skin.landmark(nipple), split_side(nipple)[1], center)

    def _covariance(self, error: float, outwards: Array) -> Array:
        share = self._settings.inside_depth_share**2
        return np.asarray(
            (error / BALL) ** 2 * 3.0 / (2.0 + share) * (np.eye(3) - (1.0 - share) * np.outer(outwards, outwards))
        )

    def _radius(self, place: Array) -> float | None:
        """90 % radius (m) of the skin's location there."""
        radii, search = self._scan.radii, self._scan.search(self._rig)
        return None if radii is None else float(radii_at(self._rig, search, radii, place[None])[0])

    def _off(self, place: Array) -> float | None:
        """Half of the 90 % interval (m) of its location along any direction."""
        radius = self._radius(place)
        return None if radius is None else LINE / BALL * radius

    @cached_property
    def _meshes(self) -> tuple[Any, Any, Any]:
        """Trimeshes of the skin, of the estimated chest wall and of the one that is seen; None where there is none."""
        from trimesh import Trimesh  # 0.4 s, which a plan without lesions need not wait for

        skin = Trimesh(self._scan.vertices, self._rig.faces, process=False)
        estimated, seen = (
            None if wall is None else Trimesh(wall.vertices, wall.triangles, process=False)
            for wall in (self._wall, self._scan.wall)
        )
        return skin, estimated, seen

    def _slices(self, center: Array, is_wall_seen: bool) -> tuple[Slice, ...]:
        axes, slices = self._skin.axes, []
        whole, estimated, seen = self._meshes
        chest = seen if is_wall_seen else estimated
        for plane, ((across, sign), (along, upwards)) in PLANES.items():
            right, up = sign * axes[:, across], upwards * axes[:, along]
            cuts = [
                None if mesh is None else mesh.section(plane_normal=np.cross(right, up), plane_origin=center)
                for mesh in (whole, chest)
            ]
            flat = np.column_stack([right, up])
            skin, wall = (
                tuple((cut.vertices[each.points] - center) @ flat for each in cut.entities) if cut is not None else ()
                for cut in cuts
            )
            slices.append(Slice(plane, right, up, skin, wall))
        return tuple(slices)

    def outline(self, lesion: PlacedLesion) -> Polyline:
        """The lesion's outline on the skin next to it, to which the shortest way leads."""
        nearest = self._skin.nearest(lesion.center[None])
        middle, outwards = self._skin.at(nearest), nearest.directions(self._normals, self._rig.faces)
        side = unit_vectors(np.cross(outwards, np.eye(3)[np.abs(outwards).argmin()]))
        angles = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)[:, None]
        radius = 1e-3 * lesion.item.radius_mm
        rim = middle + radius * (np.cos(angles) * side + np.sin(angles) * np.cross(outwards, side))
        shape = DrawnShape(lesion.item.name, lesion.item.name, True, LESION, self._skin.nearest(rim))
        (line,) = on_scan(self._rig, self._scan.vertices, ModelDrawing("lesion", "lesion", (shape,)), self._scan.target)
        return replace(line, error=None if lesion.error is None else np.full(len(line.points), lesion.error))


def distances_to_lines(lesion: PlacedLesion, lines: Sequence[Polyline]) -> tuple[Distance, ...]:
    """Distances from the lesion to the nearest point of each line, nearest line first."""
    found = []
    for line in lines:
        edges = line.edges if len(line.edges) else np.array([[0, 0]])
        corners = line.points[edges[:, [0, 1, 1]]]
        weights = closest_barycentric(np.broadcast_to(lesion.center, (len(edges), 3)), corners)
        points = np.einsum("ec,ecd->ed", weights, corners)
        k = int(np.linalg.norm(points - lesion.center, axis=1).argmin())
        off = 0.0 if line.error is None else LINE / BALL * float(line.error[edges[k, 0]])
        off_known = None if np.isnan(off) else off
        found.append(_distance("line", line.name, points[k], lesion.center, lesion.covariance, off_known))
    return tuple(sorted(found, key=lambda each: each.length))


def _distance(
    kind: Kind, to: str, point: Array, center: Array, covariance: Array | None, off: float | None
) -> Distance:
    """The distance to a point; `off` (m) is half of the 90 % interval of that point along the way to it."""
    way = point - center
    length = float(np.linalg.norm(way))
    if covariance is None or off is None:
        return Distance(kind, to, point, length, None)
    along = way / max(length, 1e-9)
    return Distance(kind, to, point, length, float(np.hypot(LINE * np.sqrt(along @ covariance @ along), off)))


def _lesions(rig: Rig, scan: FittedScan, items: Iterable[PlanItem]) -> Iterator[tuple[PlanLesion, bool]]:
    """The lesions and the tumours by the clock with a known depth, each with whether it is such a tumour."""
    skin = FittedSkin(rig, scan.vertices, scan.known)
    for item in items:
        if isinstance(item, PlanLesion):
            yield item, False
        elif isinstance(item, PlanTumour) and item.depth_mm is not None:
            with suppress(BadDrawing):  # its circle is missing, with the reason
                place = Tumour.model_validate(asked_of(item)[1]).centre(skin)
                outwards = place.directions(vertex_normals(scan.vertices, rig.faces), rig.faces)[0]
                center = 1e3 * skin.at(place)[0] - item.depth_mm * outwards
                name = f"Tumour, {SIDES[item.side]}"
                yield (
                    PlanLesion(id=item.id, scan=item.scan, name=name, center=center.tolist(), radius_mm=item.radius_mm),
                    True,
                )


def _center(item: PlanLesion) -> Array:
    return 1e-3 * np.array(item.center, dtype=np.float64)
