"""A chest wall that a body may have: under the skin around the breasts, as deep as in women, round without them.

Trunks are unrolled around an axis through their middle: angles (0 in front, to the left) and heights.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.ndimage import map_coordinates

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.normals import vertex_normals
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.body import breast_region

WIDEST = np.radians(105.0)
STEP = 0.005  # m of the wall's own net
SMOOTH = 1e-4  # of the sheet
POINTS = 700  # of the skin around the breasts
RADIUS = 0.14  # m, at which angles are lengths
LEAST = 0.007  # m of soft tissue anywhere
SPREAD = 0.02  # m over which a wall is lowered that is not so deep
ASIDE = 0.02  # m from the midline, in which the breastbone lies


@dataclass(frozen=True, eq=False)
class Wall:
    """Radii on a net of angles and heights."""

    axis: tuple[float, float]  # m, x and z
    angles: Array  # (A,)
    heights: Array  # (H,) m
    radii: Array  # (A, H) m

    def flat(self, points: Array) -> tuple[Array, Array]:
        """((M, 2) angle and height, (M,) m from the axis)."""
        x, z = points[:, 0] - self.axis[0], points[:, 2] - self.axis[1]
        return np.stack([np.arctan2(x, z), points[:, 1]], axis=1), np.hypot(x, z)

    def radius(self, flat: Array) -> Array:
        """(M,) m."""
        at = [(flat[:, k] - each[0]) / (each[1] - each[0]) for k, each in enumerate((self.angles, self.heights))]
        return np.asarray(map_coordinates(self.radii, at, order=1, mode="nearest"))

    def over(self, points: Array) -> Array:
        """(M,) m: how far points lie outside of the wall, along the radius."""
        flat, away = self.flat(points)
        return np.asarray(away - self.radius(flat))

    @property
    def vertices(self) -> Array:
        """(A * H, 3) m."""
        angle, height = (each.ravel() for each in np.meshgrid(self.angles, self.heights, indexing="ij"))
        x, z = self.axis
        return np.stack(
            [x + self.radii.ravel() * np.sin(angle), height, z + self.radii.ravel() * np.cos(angle)], axis=1
        )

    @property
    def faces(self) -> Integers:
        """(F, 3), counter-clockwise from outside."""
        number = np.arange(self.radii.size).reshape(self.radii.shape)
        a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
        return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    @property
    def normals(self) -> Array:
        """(A * H, 3)."""
        return vertex_normals(self.vertices, self.faces)


def footprint(body: VirtualBody, faces: Integers) -> Booleans:
    """(V,) the vertices of both breasts."""
    at = body.landmarks
    found: Booleans = np.any(
        [
            breast_region(
                body.vertices, faces, at[f"nipple_{s}"], at[f"inframammary_fold_{s}"], float(at["xiphoid"][0])
            )
            for s in "LR"
        ],
        axis=0,
    )
    return found


def drawn_wall(body: VirtualBody, faces: Integers, breasts: Booleans, arms: Array, random: np.random.Generator) -> Wall:
    """A wall under a standing body; `breasts` (V,), `arms` (V,) share of the arms."""
    at, skin = body.landmarks, body.vertices
    level = np.abs(skin[:, 1] - at["xiphoid"][1]) < 0.02
    trunk = skin[level & (arms < 0.1), 2]
    axis = (float(at["xiphoid"][0]), float(0.5 * (trunk.min() + trunk.max())))
    low, high = min(at[f"inframammary_fold_{s}"][1] for s in "LR") - 0.09, at["suprasternal_notch"][1] + 0.01
    angles = np.linspace(-WIDEST, WIDEST, int(2 * WIDEST * RADIUS / STEP))
    heights = np.linspace(low, high, int((high - low) / STEP))
    empty = Wall(axis, angles, heights, np.zeros((len(angles), len(heights))))
    flat, away = empty.flat(skin)
    near = (arms < 0.1) & (np.abs(flat[:, 0]) < WIDEST + 0.3) & (flat[:, 1] > low - 0.03) & (flat[:, 1] < high + 0.03)
    around = np.flatnonzero(near & ~breasts)
    around = random.choice(around, min(POINTS, len(around)), replace=False)
    sheet = RBFInterpolator(
        flat[around] * [RADIUS, 1.0], away[around], kernel="thin_plate_spline", smoothing=SMOOTH, degree=1
    )
    angle, height = np.meshgrid(angles, heights, indexing="ij")
    places = np.stack([RADIUS * angle.ravel(), height.ravel()], axis=1)
    bone, elsewhere = random.uniform(0.009, 0.014), random.uniform(0.014, 0.026)
    share = np.clip((np.abs(places[:, 0]) - ASIDE) / 0.04, 0.0, 1.0)
    deep = bone + (elsewhere - bone) * share * share * (3.0 - 2.0 * share)
    wall = Wall(axis, angles, heights, (sheet(places) - deep).reshape(angle.shape))
    over = wall.over(skin[near])  # where a sheet is too far out it lies under the skin
    tight = np.flatnonzero(near)[over < LEAST]
    if len(tight):
        gaps = np.linalg.norm(places[:, None] - flat[tight] * [RADIUS, 1.0], axis=2)
        lower = ((LEAST - over[over < LEAST]) * np.exp(-0.5 * (gaps / SPREAD) ** 2)).max(axis=1)
        wall = replace(wall, radii=wall.radii - lower.reshape(angle.shape))
    return wall
