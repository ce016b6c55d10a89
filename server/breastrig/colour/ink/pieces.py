"""Unbroken pieces of lines, and whether their colour is that of ink.

A piece is judged by its mean optical density across, against the bare skin on both sides: markers add density in red or
green, skin's pigments most in blue and least in red; creases are wider, hair narrower, and an edge of cloth has skin on
one side only.  On dark skin ink turns the hue to blue, green or red.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from breastrig.colour.ink import limits
from breastrig.colour.ink.chains import neighbours_joined
from breastrig.colour.ink.ridges import DENSITY, OFFSETS, RidgePoints, darkening, hue_of, profiles
from breastrig.colour.skin_texture import SkinTexture
from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.polyline import arc_lengths, interpolated

MIDDLE = np.abs(OFFSETS) < 0.8e-3
LEFT, RIGHT = OFFSETS < -2.8e-3, OFFSETS > 2.8e-3
WITHIN = np.abs(OFFSETS) < 2.8e-3


class Ink(Enum):
    """The possible inks of a density."""

    COLOURED = "coloured"  # violet, blue, green
    BLACK = "black"
    RED = "red"


@dataclass(frozen=True, eq=False)
class Piece:
    """P points of an unbroken line, in order."""

    places: Array  # (P, 3) m on the skin, in the scan's frame
    faces: Integers  # (P,) triangles of the scan
    closed: bool
    length: float  # m
    added: Array  # (3,) density of red, green, blue above the skin's
    skin: Array  # (3,) density of the skin on both sides
    width: float  # m
    hue: float  # of the line over that of the skin on both sides, whichever differs less; 0 where it lies between both

    def ends(self) -> tuple[Array, Array]:
        """((2, 3) m first and last place, (2, 3) unit vectors that lead out of them)."""
        at = arc_lengths(self.places)
        back = min(limits.END, float(at[-1]))
        inner = interpolated(np.array([back, at[-1] - back]), at, self.places)
        tips = self.places[[0, -1]]
        out = tips - inner
        return tips, out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)


def ink_of(
    added: Array, width: float, share: float = 1.0, has_black: bool = False, hue: float | None = None
) -> Ink | None:
    """The ink that adds (3,) densities in a line of that width (m), or None; `share` scales the thresholds.

    `has_black`: the scan surely has black ink, of which this may be a faint line. `hue` is a piece's, by default that
    of `added`.
    """
    red, green, blue = (float(value) for value in added)
    if width > limits.WIDEST_HUE:
        return None
    hue = float(hue_of(added)) if hue is None else hue
    lighter = -min(green, blue)
    opposed = hue >= share * limits.HUE_OF_OPPOSED and red + lighter >= share * limits.OPPOSED
    if (
        (opposed or hue >= share * limits.HUE)
        and red > -limits.NO_DARKER_RED * lighter
        and lighter >= share * limits.LIGHTER
    ):
        return Ink.COLOURED
    if hue <= -share * limits.HUE and green >= share * limits.DARKER_GREEN and red <= limits.LIGHTER_RED * green:
        return Ink.RED
    if width > limits.WIDEST:
        return None
    over = green - red >= share * limits.RED_OVER and green >= limits.RED_SHARE * red
    if over and min(green, blue) >= share * limits.RED:
        return Ink.RED if blue <= limits.RED_BLUE * green else None
    if blue < green < limits.PURE * red:
        return None
    if red >= share * limits.COLOURED and red - min(green, blue) >= share * limits.COLOURED_OVER:
        return Ink.COLOURED
    faint = red >= share * limits.FAINT_BLACK and blue <= limits.FAINT_BLUE * red
    if has_black and faint and limits.FAINT_NARROWEST <= width <= limits.WIDEST_BLACK:
        return Ink.BLACK
    most = limits.DARK_BLUE if red >= share * limits.DARK else limits.BLACK_BLUE
    black = red >= share * limits.BLACK and blue <= most * red and width <= limits.WIDEST_BLACK
    return Ink.BLACK if black and (width >= limits.NARROWEST_BLACK or red >= limits.CLEARLY_BLACK) else None


@dataclass(frozen=True, eq=False)
class Measured:
    """N unbroken lines of ridge points on skin, of any colour."""

    lines: tuple[Piece, ...]

    def pieces(self, factor: float = 1.0, has_black: bool = False) -> list[Piece]:
        """The pieces that may be ink; `factor` scales densities, `has_black` as in `ink_of`."""
        share = factor * limits.LENIENT
        may_be = [line for line in self.lines if ink_of(line.added, line.width, share, has_black, line.hue)]
        return _without_doubles(_without_echoes(may_be))


def measured(texture: SkinTexture, found: Sequence[RidgePoints]) -> Measured:
    """All lines of the points found in each picture of the texture."""
    places = np.concatenate([points.places for points in found])
    tangents = np.concatenate([points.tangents for points in found])
    heights = np.concatenate([points.heights for points in found])
    faces = np.concatenate([points.faces for points in found])
    joined = neighbours_joined(places, tangents, limits.REACH, limits.TURN)
    if not joined:
        return Measured(())
    order = np.concatenate([chain for chain, _ in joined])
    counts = np.array([len(chain) for chain, _ in joined])
    starts = np.cumsum(counts) - counts
    step = np.zeros(len(order))
    step[1:] = np.sqrt(((places[order[1:]] - places[order[:-1]]) ** 2).sum(axis=1))
    step[starts] = 0.0
    lengths = np.add.reduceat(step, starts)
    high = np.add.reduceat(heights[order], starts) / counts
    kept = np.flatnonzero((lengths >= limits.PIECE) & (high >= limits.PIECE_HEIGHT))
    chains = [(*joined[number], float(lengths[number])) for number in kept]
    if not chains:
        return Measured(())
    across = _profiles(texture, found, chains)
    usual = _usual_chroma(texture)
    left, middle, right, width = _measured(across, [chain for chain, _, _ in chains])
    skin = 0.5 * (left + right)
    added = middle - skin
    hue = _between(hue_of(middle - left), hue_of(middle - right))
    chroma = np.minimum(left[:, 2] - left[:, 0], right[:, 2] - right[:, 0])
    result = []
    for number in np.flatnonzero(chroma >= limits.SKIN_SHARE * usual):
        chain, closed, length = chains[number]
        result.append(
            Piece(
                places[chain],
                faces[chain],
                closed,
                length,
                added[number],
                skin[number],
                float(width[number]),
                float(hue[number]),
            )
        )
    return Measured(tuple(result))


def _between(one: Array, other: Array) -> Array:
    """(N,) of two (N,) values the one nearer to 0, and 0 where their signs differ."""
    return np.asarray(np.sign(one) * np.maximum(np.minimum(np.abs(one), np.sign(one) * other), 0.0))


def _without_echoes(found: list[Piece]) -> list[Piece]:
    """The pieces without those beside a much clearer one of the opposite hue: compressed pictures have such rims.

    Only pieces that differ from the skin in hue more than in darkness can be such rims.
    """
    if not found:
        return found
    places = np.concatenate([piece.places for piece in found])
    owner = np.repeat(np.arange(len(found)), [len(piece.places) for piece in found])
    added = np.array([piece.added for piece in found])
    hue = np.asarray(hue_of(added))
    may_be = np.abs(darkening(added)) < 0.5 * np.abs(hue)
    pairs = cKDTree(places).query_pairs(limits.ECHO, output_type="ndarray").astype(np.int64)
    one, other = owner[pairs].T
    beside = np.zeros(len(places), dtype=np.bool_)
    for column, own, near in ((0, one, other), (1, other, one)):
        echo = may_be[own] & (hue[own] * hue[near] < 0.0) & (np.abs(hue[own]) < limits.ECHO_HUE * np.abs(hue[near]))
        beside[pairs[echo, column]] = True
    share = np.bincount(owner, beside) / np.bincount(owner)
    return [piece for piece, echo in zip(found, share > 0.5, strict=True) if not echo]


def _without_doubles(found: list[Piece]) -> list[Piece]:
    """The pieces without the shorter of two side by side (a broad line with two ridges, or meeting pictures)."""
    if not found:
        return found
    places = np.concatenate([piece.places for piece in found])
    owner = np.repeat(np.arange(len(found)), [len(piece.places) for piece in found])
    pairs = cKDTree(places).query_pairs(limits.BESIDE, output_type="ndarray").astype(np.int64)
    lengths = np.array([piece.length for piece in found])
    one, other = owner[pairs].T
    beside = np.zeros(len(places), dtype=np.bool_)
    for column, shorter in ((0, lengths[one] < lengths[other]), (1, lengths[other] < lengths[one])):
        beside[pairs[shorter & (one != other), column]] = True
    share = np.bincount(owner, beside) / np.bincount(owner)
    return [piece for piece, double in zip(found, share > limits.BESIDE_SHARE, strict=True) if not double]


def _profiles(
    texture: SkinTexture, found: Sequence[RidgePoints], chains: Sequence[tuple[Integers, bool, float]]
) -> Array:
    """(M, 17, 3) of all points, nan for those of no chain."""
    wanted = np.zeros(sum(len(points.places) for points in found), dtype=np.bool_)
    for chain, _, _ in chains:
        wanted[chain] = True
    across = np.full((len(wanted), len(OFFSETS), 3), np.nan)
    start = 0
    for picture, points in zip(texture.pictures, found, strict=True):
        rows = np.flatnonzero(wanted[start : start + len(points.places)])
        if len(rows):
            across[start + rows] = profiles(picture, points.at(rows))
        start += len(points.places)
    return across


def _measured(across: Array, chains: Sequence[Integers]) -> tuple[Array, Array, Array, Array]:
    """((N, 3) density left, in the middle, right, (N,) width in m) of N chains of points with (M, 17, 3) profiles.

    Where there is no skin on one side the other counts for both; without any the densities are nan.
    """
    owner = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    values = across[np.concatenate([np.zeros(0, dtype=np.int64), *chains])].reshape(len(owner), -1)
    known = np.isfinite(values)
    gather = csr_array((np.ones(len(owner)), (owner, np.arange(len(owner)))), shape=(len(chains), len(owner)))
    count = np.asarray(gather @ known.astype(np.float64)).reshape(-1, len(OFFSETS), 3)
    total = np.asarray(gather @ np.where(known, values, 0.0)).reshape(-1, len(OFFSETS), 3)

    def mean(where: Booleans) -> Array:
        counted = count[:, where].sum(axis=1)
        return np.where(counted > 0, total[:, where].sum(axis=1) / np.maximum(counted, 1.0), np.nan)

    left, middle, right = mean(LEFT), mean(MIDDLE), mean(RIGHT)
    left, right = np.where(np.isfinite(left), left, right), np.where(np.isfinite(right), right, left)
    share = np.linspace(0.0, 1.0, len(OFFSETS))[:, None]
    whole = np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
    above = whole - (1.0 - share) * left[:, None] - share * right[:, None]
    dark, hue = darkening(above), hue_of(above)
    darker, bluer = (np.nan_to_num(each[:, MIDDLE]).mean(axis=1) for each in (dark, hue))
    by_hue = limits.HUE_WORTH * np.abs(bluer) > darker  # ink that is lighter than the skin has no other width
    above = np.where(by_hue[:, None], np.sign(bluer)[:, None] * hue, dark)
    above = np.maximum(np.nan_to_num(above), 0.0)
    top = np.maximum(above[:, MIDDLE].max(axis=1), 1e-6)
    return left, middle, right, above[:, WITHIN].sum(axis=1) * (OFFSETS[1] - OFFSETS[0]) / top


def _usual_chroma(texture: SkinTexture) -> float:
    """Blue density over red of the scan's skin: the median, as skin is most of a scan of a body."""
    density = DENSITY[texture.face_colours]
    return float(np.median(density[:, 2] - density[:, 0]))
