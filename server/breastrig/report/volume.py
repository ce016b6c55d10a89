"""Breast volume: between the skin inside the breast's outline and an estimated chest wall (docs/decisions/0016).

The wall is a thin-plate spline (Duchon 1977) of the distance from the body's long axis through three level lines of the
skin: on the outline, 10 mm and 20 mm outside it.  The volume is the signed flux between skin and wall.  The outline is
the model's `breast_base`, corrected by measures.toml; the band is that of its error and of the fit's mean distance.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import components
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.fields.level_sets import crossings, part_above
from breastrig.geometry.normals import face_areas, face_crosses, vertex_normals
from breastrig.geometry.polyline import resampled
from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import measure_calibration
from breastrig.report.stance import Stance
from breastrig.rig.model import DrawnShape, Rig

OUTLINE_ERROR = 0.005  # m, how far apart two raters draw the outline (Wesselius 2018: 3.5 to 6.7 mm)
BORDER_DISTANCES = (0.0, 0.010, 0.020)  # m outside the outline; farther out: another slope, and the other breast
SPACING = 0.003  # m between points of the outline: well below the mesh's edges
SMOOTHING = 1e-5  # of the spline, in units of the chest's radius: keeps points on top of each other solvable
METHOD = (
    "between the fitted skin inside the breast base outline and a thin-plate spline through the skin on, 10 mm and "
    "20 mm outside it, as if there were no breast (meshes of `breastrig volume` go on to the pectoral muscle, some "
    "12 mm deeper); band: the outline's error in and out, and the mean distance of fit and scan over the whole area"
)


@dataclass(frozen=True, eq=False)
class Volume:
    """The volume of one breast."""

    value: float  # m³
    low: float  # m³
    high: float  # m³
    area: float  # m² of skin inside the outline
    seen: float  # share of the model's vertices inside the outline that the scan shows


@dataclass(frozen=True, eq=False)
class Axis:
    """The line around which the chest curves."""

    point: Array  # (3,) m
    direction: Array  # (3,) unit


def volume_above(
    vertices: Array, faces: Integers, inside: Array, axis: Axis, level: float = 0.0
) -> tuple[float, float]:
    """(m³, m²): volume over the smooth continuation of the surroundings, and skin area, where `inside` > level.

    `inside` (V,) m is the distance to the outline, above zero within it.  (0, 0) when nothing is inside.
    """
    from scipy.interpolate import RBFInterpolator  # slow to load, and most fits need no spline

    patch, triangles = part_above(vertices, faces, inside, level)
    if not len(triangles):
        return 0.0, 0.0
    border = np.concatenate([crossings(vertices, faces, inside, level - away) for away in BORDER_DISTANCES])
    out = border.mean(axis=0) - axis.point
    out -= axis.direction * (out @ axis.direction)
    radius = float(np.linalg.norm(out))
    axes = np.stack([out / radius, np.cross(axis.direction, out / radius), axis.direction], axis=1)

    def unrolled(points: Array) -> tuple[Array, Array]:
        """(M, 2) along the chest and (M,) above its mean radius, both in units of that radius."""
        x, y, z = ((points - axis.point) @ axes).T
        return np.stack([np.arctan2(y, x), z / radius], axis=1), np.hypot(x, y) / radius - 1.0

    at, height = unrolled(border)
    wall_of = RBFInterpolator(at, height, kernel="thin_plate_spline", smoothing=SMOOTHING)
    under, _ = unrolled(patch)
    reach = radius * (1.0 + wall_of(under))
    angle = under[:, 0]
    wall = np.stack([reach * np.cos(angle), reach * np.sin(angle), radius * under[:, 1]], axis=1) @ axes.T + axis.point
    middle = border.mean(axis=0)
    skin, bed = (enclosed_volume(place - middle, triangles) for place in (patch, wall))
    return skin - bed, float(face_areas(patch, triangles).sum())


def enclosed_volume(vertices: Array, faces: Integers) -> float:
    """m³ between the origin and the triangles, those that face it counted below zero: what a closed surface holds."""
    return float(np.einsum("fi,fi->", vertices[faces].mean(axis=1), face_crosses(vertices, faces)) / 6.0)


def breast_outline(rig: Rig, side: str) -> DrawnShape | None:
    """The closed line around the breast on `side` ("L" or "R"); None for a rig that has none, or no nipple."""
    shapes = {shape.name: shape for drawing in rig.drawings for shape in drawing.shapes if shape.closed}
    found = next((shapes[name] for name in (f"breast_base_{side}", f"breast_{side}") if name in shapes), None)
    return found if f"nipple_{side}" in rig.landmark_names else None


@lru_cache(maxsize=16)
def vertices_within(rig: Rig, side: str) -> Booleans | None:
    """(V,) the vertices inside the breast's outline, read-only; None for a rig without one."""
    outline = breast_outline(rig, side)
    if outline is None:
        return None
    inside = _within(rig, outline, f"nipple_{side}")
    inside.flags.writeable = False
    return inside


def seen_share(stance: Stance, side: str) -> float | None:
    """Share of the model's vertices inside the breast's outline that the scan shows; None for a rig without one."""
    within = vertices_within(stance.rig, side)
    return None if within is None else float(np.isfinite(stance.distances[within]).sum()) / max(int(within.sum()), 1)


def breast_volume(stance: Stance, side: str) -> Volume | None:
    """The volume of the breast on `side` ("L" or "R"); None for a rig without an outline of the breast."""
    rig = stance.rig
    outline, within = breast_outline(rig, side), vertices_within(rig, side)
    if outline is None or within is None:
        return None
    line = resampled(outline.points.positions(stance.vertices, rig.faces), SPACING, closed=True)
    inside = np.where(within, 1.0, -1.0) * _distance_to_line(stance.vertices, line)
    faces = _without_arms(rig)
    frame = body_frame(rig, stance.vertices)
    axis = Axis(frame.middle, frame.axes[:, 1])
    outwards, error = _outline_error(stance, line)
    low, (value, area), high = (
        volume_above(stance.vertices, faces, inside, axis, level - outwards) for level in (error, 0.0, -error)
    )
    gaps = stance.distances[within]
    known = gaps[np.isfinite(gaps)]
    hidden = area * abs(float(known.mean())) if len(known) else 0.0
    return Volume(
        value=value,
        low=value - float(np.hypot(value - low[0], hidden)),
        high=value + float(np.hypot(high[0] - value, hidden)),
        area=area,
        seen=len(known) / max(len(gaps), 1),
    )


def _outline_error(stance: Stance, line: Array) -> tuple[float, float]:
    """(m, m): the outward correction of the outline (N, 3), and the radius (90 %) of its error after that."""
    calibration = measure_calibration(stance.rig)
    if calibration is None or stance.radii is None:
        return 0.0, OUTLINE_ERROR
    known = calibration.outline(stance.name)
    radii = stance.on_model(line).positions(stance.radii[:, None], stance.rig.faces)
    return known.outwards, known.of(float(radii.mean()))


def _distance_to_line(points: Array, line: Array) -> Array:
    """(M,) m from (M, 3) points to a closed line of (N, 3) points."""
    index = np.arange(len(line))
    after = (index + 1) % len(line)
    segments = np.stack([index, after, after], axis=1)  # triangles without area: their closest point is the segment's
    return ClosestPointSearch(line, segments).query(points).distances


def _within(rig: Rig, outline: DrawnShape, nipple: str) -> Booleans:
    """(V,) the vertices of the template inside the outline: those on the nipple's side of it that hang together."""
    line = resampled(outline.points.positions(rig.template, rig.faces), SPACING, closed=True)
    on = ClosestPointSearch(rig.template, rig.faces).query(line)
    facing = np.einsum("mc,mcd->md", on.barycentric, vertex_normals(rig.template, rig.faces)[rig.faces[on.faces]])
    inwards = np.cross(facing, np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0))
    tip = rig.landmark_points((nipple,)).positions(rig.template, rig.faces)[0]
    if np.einsum("mi,mi->m", inwards, tip - line).sum() < 0.0:
        inwards = -inwards
    gaps = np.linalg.norm(rig.template[:, None] - line[None], axis=2)
    nearest = gaps.argmin(axis=1)
    positive = np.einsum("vi,vi->v", rig.template - line[nearest], inwards[nearest]) > 0.0
    edges = rig.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[positive[edges].all(axis=1)]
    count = len(rig.template)
    _, label = components(count, edges[:, 0], edges[:, 1])
    seed = int(np.linalg.norm(rig.template - tip, axis=1).argmin())
    return np.asarray(positive & (label == label[seed]))


def _without_arms(rig: Rig) -> Integers:
    """Triangles that touch no arm: hanging arms come close to the breast's side without belonging to the chest."""
    arm = np.zeros(len(rig.template), dtype=np.bool_)
    for name, members in rig.regions.items():
        if name.startswith("arm"):
            arm[members] = True
    return rig.faces[~arm[rig.faces].any(axis=1)]
