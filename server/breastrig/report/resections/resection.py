"""What closed planned lines on a breast enclose, down to a depth or to the chest wall: ml, grams, share of the breast.

The tissue of a line is in columns that lead from the skin inside it to the estimated chest wall (volume/tetrahedra.py);
a depth ends them where they are so far from the nearest skin.  The breast is measured in the same way inside its
outline, so it is larger than the report's volume, which ends before the fat behind the breast.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.core.settings_file import SettingsPart, packaged
from breastrig.core.stances import SIDES, split_side
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.geometry.boundary import components
from breastrig.geometry.caps import walled
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.fields.level_sets import part_above
from breastrig.geometry.half_edges import split_flat
from breastrig.geometry.normals import face_areas, vertex_normals
from breastrig.geometry.polyline import Polyline, resampled
from breastrig.report.body_frame import body_frame
from breastrig.report.stance import Stance
from breastrig.report.volume import breast_outline, enclosed_volume

NOT_CUT = ("areola", "new_nipple", "breast", "breast_base")  # closed lines that mark a place
SMALL = 2e-6  # m³, under which a line encloses nothing worth a row
WallUnder = Callable[[], Array | None]  # (V, 3) m, the chest wall under the model's vertices; it takes half a second
STEP = 0.001  # m between points of a line
HALVINGS = 10  # of a column, to a twentieth of a millimetre


@dataclass(frozen=True)
class Taken:
    """What is inside a line down to one depth; m³."""

    depth: float | None  # m below the skin; None: to the chest wall
    volume: float
    band: tuple[float, float] | None  # with the chest wall at both ends of its 90 % interval; None: no wall, not known
    share: float  # of that breast, of what is inside its outline
    other: float  # at the mirrored place of the other side
    after: float  # what is left of the breast


@dataclass(frozen=True)
class Resection:
    """A closed line on one breast."""

    line: str
    side: str  # L or R
    breast: float  # m³ inside its outline, down to the chest wall
    other_breast: float
    rows: tuple[Taken, ...]


class _Numbers(SettingsPart):
    """resection.toml"""

    density_g_per_ml: float
    density_deviation: float
    depths_mm: list[float]


@cache
def resection_numbers() -> _Numbers:
    """The density of breast tissue, and the depths that are shown."""
    return packaged(_Numbers, "breastrig.report.resections", "resection.toml")


class Columns:
    """A body of (V, 3) m skin with the (V, 3) m chest wall under it, and (F, 3) triangles."""

    def __init__(self, skin: Array, wall: Array, faces: Integers) -> None:
        self.search = ClosestPointSearch(skin, faces)
        both, self.faces, _ = split_flat(np.concatenate([skin, wall], axis=1), faces)
        self.skin, self.wall = both[:, :3], both[:, 3:]

    def inside(self, line: Array) -> Array:
        """(W,) m to a closed line of (M, 3) m points, above zero inside: on that of its sides which has less skin."""
        points = resampled(line, STEP, closed=True)
        away, nearest = map(np.asarray, cKDTree(points).query(self.skin))
        ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
        across = np.cross(vertex_normals(self.skin, self.faces), ahead[nearest])
        on_left = np.einsum("vi,vi->v", across, self.skin - points[nearest]) > 0.0
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        edges = edges[on_left[edges[:, 0]] == on_left[edges[:, 1]]]
        _, part = components(len(self.skin), *edges.T)
        areas = np.bincount(part[self.faces].ravel(), np.repeat(face_areas(self.skin, self.faces) / 3.0, 3))
        beside = [
            part[on_left == side][np.argmin(away[on_left == side])] for side in (False, True) if (on_left == side).any()
        ]
        within = part == min(beside, key=lambda each: areas[each])
        return np.asarray(np.where(within, away, -away))

    def volume(self, inside: Array, depth: float | None = None, lowered: float = 0.0) -> float:
        """m³ under the skin with (W,) `inside` above zero, down to a depth (m), or to the wall moved `lowered` m on."""
        both, patch = part_above(np.concatenate([self.skin, self.wall], axis=1), self.faces, inside, 0.0)
        if not len(patch):
            return 0.0
        top, column = both[:, :3], both[:, 3:] - both[:, :3]
        column *= 1.0 + lowered / np.maximum(np.linalg.norm(column, axis=1, keepdims=True), 1e-6)
        end = np.ones(len(top))
        if depth is not None:
            start = np.zeros(len(top))
            for _ in range(HALVINGS):
                middle = 0.5 * (start + end)
                is_deeper = self.search.query(top + middle[:, None] * column).distances >= depth
                start, end = np.where(is_deeper, start, middle), np.where(is_deeper, middle, end)
        closed, triangles = walled(top + end[:, None] * column, top, patch)
        return enclosed_volume(closed - top.mean(axis=0), triangles)


def no_wall() -> None:
    """Of a rig whose inside nobody knows."""


def resections(stance: Stance, wall_under: WallUnder, planned: Mapping[str, float]) -> tuple[Resection, ...]:
    """The closed lines of a stance that enclose some of a breast; none where the chest wall is not known.

    `planned`: m, how deep lines of these names are to be cut, beside the depths that are always shown.
    """
    rig, frame = stance.rig, body_frame(stance.rig, stance.vertices)
    shapes = [(side, shape) for side in SIDES if (shape := breast_outline(rig, side)) is not None]
    lines = [
        each
        for each in stance.lines
        if each.closed and len(each) > 2 and split_side(each.name.partition(" ")[0])[0] not in NOT_CUT
    ]
    if not lines or len(shapes) < len(SIDES) or (wall := wall_under()) is None:
        return ()
    body = Columns(stance.vertices, wall, rig.faces)
    breasts = {side: body.inside(shape.points.positions(stance.vertices, rig.faces)) for side, shape in shapes}
    whole = {side: body.volume(within) for side, within in breasts.items()}
    error = skin_map_settings(rig).wall_error.get(stance.name)
    depths = [1e-3 * each for each in resection_numbers().depths_mm]
    found = []
    for line in lines:
        side, other = ("L", "R") if frame.lateral(line.points.mean(axis=0)) > 0.0 else ("R", "L")
        here, there = body.inside(line.points), body.inside(_mirrored(stance, line))
        rows = []
        for depth in (*sorted({*depths, planned.get(line.name, depths[0])}), None):
            off = (
                None if depth is not None or error is None else [body.volume(here, None, by) for by in (-error, error)]
            )
            of_breast = body.volume(np.minimum(here, breasts[side]), depth)
            rows.append(
                Taken(
                    depth,
                    body.volume(here, depth),
                    None if off is None else (off[0], off[1]),
                    of_breast / whole[side],
                    body.volume(there, depth),
                    whole[side] - of_breast,
                )
            )
        if rows[-1].share * whole[side] > SMALL:
            found.append(Resection(line.name, side, whole[side], whole[other], tuple(rows)))
    return tuple(found)


def _mirrored(stance: Stance, line: Polyline) -> Array:
    """(M, 3) m: the line's places on the model, on the other side of the body."""
    on, faces = stance.on_model(line.points), stance.rig.mirror_vertices[stance.rig.faces]
    return on.positions(stance.vertices, faces)
