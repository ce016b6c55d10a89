"""Middles of thin lines in one picture of the skin, to a fraction of a pixel.

Colours are optical densities, -log of the linear light, in red and green, where ink differs from skin's pigments; on
the darkest skin the hue.  A line is where the smoothed density has its maximum across (Steger, An unbiased detector of
curvilinear structures, 1998).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, uniform_filter

from breastrig.colour.ink import limits
from breastrig.colour.ink.limits import OFF_PIXEL, ON_SKIN, WEAK, WIDTH
from breastrig.colour.skin_texture import SkinPicture
from breastrig.core.arrays import Array, Booleans, Integers, frozen
from breastrig.core.srgb import to_light
from breastrig.geometry.normals import unit_vectors

Single = NDArray[np.float32]
Real = TypeVar("Real", np.float32, np.float64)
DARKEST = 2e-3  # of full light: sRGB 1 of 255 is 0.3e-3, and noise decides there
SHARE = 0.2  # of the filter's weight that must lie on skin
CELL = 3  # pixels; signals are compared over three cells along both ways
TRUNCATE = 3.0  # standard deviations
JUMP, STEEPEST = 2e-3, 2.0  # m of depth, and m for each m aside, that skin which is seen at all may reach
OFFSETS: Array = frozen(0.5e-3 * np.arange(-8, 9))  # m across a line; all of a pen's width, and bare skin on both sides


@dataclass(frozen=True, eq=False)
class RidgePoints:
    """M points, each the middle of a line in a picture."""

    places: Array  # (M, 3) m on the skin, in the scan's frame
    tangents: Array  # (M, 3) unit vectors along the line, of either sign
    faces: Integers  # (M,) triangles of the scan
    heights: Array  # (M,) density that the filter sees above the skin's
    spots: Array  # (M, 2) row and column in the picture
    along: Array  # (M, 2) unit vector along the line in the picture, rows and columns

    def at(self, rows: Integers) -> "RidgePoints":
        """The points at these indices."""
        return RidgePoints(*(getattr(self, each.name)[rows] for each in fields(RidgePoints)))


def darkening(density: NDArray[Real]) -> NDArray[Real]:
    """(...) of (..., 3) densities, red, green and blue: the darkening of lighter skin by any ink."""
    return np.asarray(0.5 * (density[..., 0] + density[..., 1]), dtype=density.dtype)


def hue_of(density: NDArray[Real]) -> NDArray[Real]:
    """(...) of (..., 3) densities: red over the others, the change by coloured ink on the darkest skin too.

    Violet, blue and green raise it, red lowers it.
    """
    return np.asarray(density[..., 0] - 0.5 * (density[..., 1] + density[..., 2]), dtype=density.dtype)


DENSITY: Single = frozen(-np.log(np.maximum(to_light(np.arange(256) / 255.0), DARKEST)), np.float32)  # of sRGB bytes


def ridge_points(picture: SkinPicture, own: Booleans) -> RidgePoints:
    """The ridge points of a picture on its own triangles (F,); other pictures have those of the others."""
    skin, density = picture.skin, np.moveaxis(DENSITY.take(np.moveaxis(picture.pixels, 2, 0)), 0, 2)
    weight = gaussian_filter(skin.astype(np.float32), WIDTH / picture.texel, truncate=TRUNCATE)
    dark = _smoothed(darkening(density), skin, weight, picture.texel)
    coloured = _smoothed(hue_of(density), skin, weight, picture.texel)
    found = [_tops_of(smooth, picture, own, weight) for smooth in (dark, coloured, -coloured)]
    return _strongest(found, (1.0, limits.HUE_WORTH, limits.HUE_WORTH), skin.shape)


def _smoothed(signal: Single, skin: Booleans, weight: Single, texel: float) -> Single:
    smooth = gaussian_filter(signal * skin, WIDTH / texel, truncate=TRUNCATE)
    smooth /= np.maximum(weight, SHARE)
    return np.asarray(smooth)


def _tops_of(smooth: Single, picture: SkinPicture, own: Booleans, weight: Single) -> RidgePoints:
    """The tops of a smoothed signal that stand out of the skin by WEAK at least."""
    sigma = WIDTH / picture.texel
    rows, columns = _candidates(smooth, picture.skin, WEAK / _gain(sigma))
    faces = picture.faces[rows, columns].astype(np.int64)
    mine = own[faces] & (weight[rows, columns] > ON_SKIN)
    rows, columns, faces = rows[mine], columns[mine], faces[mine]
    spots, along, curvature = _tops(smooth, rows, columns)
    found = (curvature * _gain(sigma) >= WEAK) & np.isfinite(spots).all(axis=1)
    spots, along, faces, curvature = spots[found], along[found], faces[found], curvature[found]
    places = picture.places(spots[:, 0], spots[:, 1], faces)
    ahead = picture.places(spots[:, 0] + along[:, 0], spots[:, 1] + along[:, 1], faces)
    return RidgePoints(places, unit_vectors(ahead - places), faces, curvature * _gain(sigma), spots, along)


def _strongest(found: Sequence[RidgePoints], worth: Sequence[float], shape: tuple[int, ...]) -> RidgePoints:
    """The points of each signal where it is the strongest around; a signal's lines stay unbroken.

    `worth` scales the heights of each signal.
    """
    cells = tuple(side // CELL + 1 for side in shape)
    spots = [np.rint(points.spots).astype(np.int64).T // CELL for points in found]
    around = []
    for points, each, (row, column) in zip(found, worth, spots, strict=True):
        total = np.bincount(row * cells[1] + column, points.heights, cells[0] * cells[1])
        around.append(each * uniform_filter(total.reshape(cells), 3))
    parts = []
    for number, (points, (row, column)) in enumerate(zip(found, spots, strict=True)):
        others = np.max([each[row, column] for other, each in enumerate(around) if other != number], axis=0)
        parts.append(points.at(np.flatnonzero(around[number][row, column] >= others)))
    return RidgePoints(*(np.concatenate([getattr(each, name.name) for each in parts]) for name in fields(RidgePoints)))


def profiles(picture: SkinPicture, points: RidgePoints) -> NDArray[np.float32]:
    """(M, 17, 3) density of red, green and blue across the line at OFFSETS (m) along the skin; nan off the skin."""
    across = np.stack([points.along[:, 1], -points.along[:, 0]], axis=1)
    beside = picture.places(points.spots[:, 0] + across[:, 0], points.spots[:, 1] + across[:, 1], points.faces)
    step = across / np.maximum(np.linalg.norm(beside - points.places, axis=1), 1e-9)[:, None]  # pixels a metre
    at = points.spots[:, None, :] + OFFSETS[:, None] * step[:, None, :]
    high, wide = picture.faces.shape
    row, column = np.rint(at).astype(np.int64).transpose(2, 0, 1)
    off = (row < 0) | (row >= high) | (column < 0) | (column >= wide)
    cell = np.where(off, 0, row * wide + column)
    faces = picture.faces.ravel().take(cell)
    off |= faces < 0
    # where nearer skin hides what is beside the line, or the line lies on the edge of the nearer skin, depth jumps
    depth = picture.depths(row.ravel(), column.ravel(), np.where(off, points.faces[:, None], faces).ravel())
    jump = np.abs(
        depth.reshape(row.shape) - picture.depths(points.spots[:, 0], points.spots[:, 1], points.faces)[:, None]
    )
    off |= jump > (JUMP + STEEPEST * np.abs(OFFSETS)) / picture.texel
    found = DENSITY.take(picture.pixels.reshape(-1, 3).take(cell, axis=0))
    found[off] = np.nan
    return found


def _gain(sigma: float) -> float:
    """Density above the skin's for each unit of curvature, of a line as wide as the filter.

    Its profile exp(-x² / 2 σ²), smoothed, has the curvature 1 / (2 √2 σ²) in the middle, and the height 1 / √2; as
    half of the lines are narrower, it is what a line of this width has that counts.
    """
    return float(2.0 * np.sqrt(2.0) * sigma**2)


def _candidates(smooth: Single, skin: Booleans, curvature: float) -> tuple[Integers, Integers]:
    """Rows and columns of pixels within the picture's border that bend that much."""
    bend = 4.0 * smooth[1:-1, 1:-1] - smooth[:-2, 1:-1]
    bend -= smooth[2:, 1:-1]
    bend -= smooth[1:-1, :-2]
    bend -= smooth[1:-1, 2:]
    rows, columns = np.nonzero((bend > 0.7 * curvature) & skin[1:-1, 1:-1])
    return rows + 1, columns + 1


def _tops(smooth: Single, rows: Integers, columns: Integers) -> tuple[Array, Array, Array]:
    """((M, 2) row and column of the top, nan where it is another pixel's, (M, 2) direction along, (M,) curvature)."""
    width = smooth.shape[1]
    flat, middle = smooth.ravel(), rows * width + columns
    value = {(i, j): flat.take(middle + i * width + j).astype(np.float64) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    by_row, by_column = 0.5 * (value[1, 0] - value[-1, 0]), 0.5 * (value[0, 1] - value[0, -1])
    rr = value[1, 0] + value[-1, 0] - 2.0 * value[0, 0]
    cc = value[0, 1] + value[0, -1] - 2.0 * value[0, 0]
    rc = 0.25 * (value[1, 1] + value[-1, -1] - value[1, -1] - value[-1, 1])
    mean, half = 0.5 * (rr + cc), np.hypot(0.5 * (rr - cc), rc)
    curvature = half - mean  # of the sharpest direction, positive for a top
    angle = 0.5 * np.arctan2(-2.0 * rc, -(rr - cc))  # of this direction, from the rows' axis
    across = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    slope = by_row * across[:, 0] + by_column * across[:, 1]
    step = (slope / np.maximum(curvature, 1e-9))[:, None] * across
    at = np.stack([rows, columns], axis=1) + step
    at[(np.abs(step) > OFF_PIXEL).any(axis=1)] = np.nan
    return at, np.stack([-across[:, 1], across[:, 0]], axis=1), curvature
