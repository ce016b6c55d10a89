"""Pieces of ink joined to strokes as the pen drew them: across gaps, dashes, crossings and holes of the scan."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from breastrig.colour.ink import limits
from breastrig.colour.ink.chains import Joints, chosen, walked
from breastrig.colour.ink.pieces import Ink, Piece, ink_of
from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.polyline import resampled

OFF_SKIN = 4.0e-3  # m from the middle of a gap to the nearest vertex; triangles have edges of some 5 mm


@dataclass(frozen=True, eq=False)
class Stroke:
    """P points of one line, evenly spaced; the gaps between its pieces are crossed straight."""

    places: Array  # (P, 3) m on the skin, in the scan's frame
    faces: Integers  # (P,) triangles of the scan
    drawn: Booleans  # (P,) ink is there; not in gaps
    bridged: Booleans  # (P,) the scan has no skin there
    closed: bool
    ink: Ink
    added: Array  # (3,) density of red, green, blue above the skin's
    skin: Array  # (3,) density of the skin beside it
    width: float  # m
    pieces: int  # of which it was joined
    length: float  # m of ink, without gaps


class _Skin:
    """The scan's skin, to tell whether a place is on it."""

    def __init__(self, places: Array) -> None:
        self._tree = cKDTree(places)

    def is_off(self, places: Array) -> Booleans:
        """(M,) whether the scan has no skin there."""
        return np.asarray(self._tree.query(places, distance_upper_bound=OFF_SKIN)[0] > OFF_SKIN)


def strokes(pieces: list[Piece], on_skin: Array, factor: float = 1.0, has_black: bool = False) -> list[Stroke]:
    """All strokes; `on_skin` (M, 3) m are places of the scan, as dense as its triangles; `factor` is of densities.

    `has_black` as in `ink_of`.
    """
    whole = [([(number, False)], True) for number, piece in enumerate(pieces) if piece.closed]
    ends = _Ends(pieces)
    skin = _Skin(on_skin)
    joints = _joints(ends, pieces, skin)
    made = chosen(joints, 2 * len(pieces))
    chains = walked(joints.first[made], joints.second[made], len(pieces))
    for chain, closed in chains:
        if not pieces[chain[0][0]].closed:
            whole.append((chain, closed))
    found = [_stroke(pieces, chain, closed, skin, factor, has_black) for chain, closed in whole]
    return [stroke for stroke in found if stroke is not None]


class _Ends:
    """The 2 N ends of N pieces: 2 i is the first, 2 i + 1 the last."""

    def __init__(self, pieces: list[Piece]) -> None:
        found = [piece.ends() for piece in pieces]
        self.tips = np.concatenate([np.zeros((0, 3)), *(tips for tips, _ in found)])
        self.out = np.concatenate([np.zeros((0, 3)), *(out for _, out in found)])
        self.open = np.repeat(np.array([not piece.closed for piece in pieces], dtype=np.bool_), 2)


def _joints(ends: _Ends, pieces: list[Piece], skin: _Skin) -> Joints:
    pairs = cKDTree(ends.tips).query_pairs(limits.HOLE, output_type="ndarray") if len(pieces) else np.zeros((0, 2))
    one, other = pairs.T.astype(np.int64)
    sound = ends.open[one] & ends.open[other]
    one, other = one[sound], other[sound]
    way = ends.tips[other] - ends.tips[one]
    gap = np.linalg.norm(way, axis=1)
    way = way / np.maximum(gap, 1e-9)[:, None]
    lengths = np.array([piece.length for piece in pieces])
    forward = np.einsum("mi,mi->m", way, ends.out[one])
    backward = -np.einsum("mi,mi->m", way, ends.out[other])
    opposed = -np.einsum("mi,mi->m", ends.out[one], ends.out[other])
    near = gap < limits.CROSSING
    straight = np.where(near, np.maximum(np.minimum(forward, backward), opposed), np.minimum(forward, backward))
    straight = np.minimum(straight, np.where(near, 1.0, opposed))
    added = np.array([piece.added for piece in pieces]).reshape(-1, 3)
    differ = np.abs(_kind(added[one // 2]) - _kind(added[other // 2])).max(axis=1)
    good = (straight > np.where(near, limits.STRAIGHT_AT_CROSSING, limits.STRAIGHT)) & (differ < limits.SAME_INK)
    # a piece shorter than the gap has a direction by chance
    good &= gap <= 2.0 * np.minimum(lengths[one // 2], lengths[other // 2])
    # a piece is joined to itself only when it comes round
    good &= (one // 2 != other // 2) | (lengths[one // 2] > 3.0 * gap)
    wide = np.flatnonzero(good & (gap > limits.GAP))
    if len(wide):
        middle = 0.5 * (ends.tips[one[wide]] + ends.tips[other[wide]])
        good[wide] = skin.is_off(middle)
    one, other, gap, straight, differ = (each[good] for each in (one, other, gap, straight, differ))
    cost = gap * (3.0 - 2.0 * straight) + limits.DIFFERENT_INK * differ
    return Joints(one, other, cost)


def _kind(added: Array) -> Array:
    """(M, 3) of (M, 3) densities: which ink, whatever its strength."""
    return np.asarray(added / np.maximum(np.abs(added).max(axis=1, keepdims=True), 1e-6))


def _stroke(
    pieces: list[Piece], chain: list[tuple[int, bool]], closed: bool, scanned: _Skin, factor: float, has_black: bool
) -> Stroke | None:
    """The stroke of pieces, in order, those marked turned round; None when as a whole it is not ink."""
    parts = [pieces[number] for number, _ in chain]
    weight = np.array([part.length for part in parts])
    added = np.average([part.added for part in parts], axis=0, weights=weight)
    width = float(np.average([part.width for part in parts], weights=weight))
    hue = float(np.average([part.hue for part in parts], weights=weight))
    ink, length = ink_of(added, width, factor, has_black, hue), float(weight.sum())
    if ink is None or length < limits.DETAIL:
        return None
    rows = []
    for number, (part, (_, turned)) in enumerate(zip(parts, chain, strict=True)):
        step = -1 if turned else 1
        rows.append(np.column_stack([part.places, np.full(len(part.places), float(number)), part.faces])[::step])
    outline = np.concatenate(rows)
    line = resampled(outline[:, :4], limits.SPACING, closed)
    if len(line) < 3:
        return None
    drawn = line[:, 3] == np.rint(line[:, 3])  # between two points of one piece, not of two
    if closed and len(parts) > 1:
        drawn &= np.concatenate([drawn[1:], drawn[:1]]) | drawn
    nearest = cKDTree(outline[:, :3]).query(line[:, :3])[1]
    sigma = limits.SMOOTH / limits.SPACING
    smooth = gaussian_filter1d(line[:, :3], sigma, axis=0, mode="wrap" if closed else "nearest")
    if not closed:  # the ends stay where the pen was put down and lifted
        for axis in range(3):
            smooth[:, axis] = _ends_kept(line[:, axis], sigma)
    bridged = ~drawn
    if bridged.any():
        bridged[bridged] = scanned.is_off(smooth[bridged])
    skin = np.average([part.skin for part in parts], axis=0, weights=weight)
    return Stroke(
        smooth,
        outline[nearest, 4].astype(np.int64),
        drawn,
        bridged,
        closed,
        ink,
        added,
        skin,
        width,
        len(parts),
        length,
    )


def _ends_kept(values: Array, sigma: float) -> Array:
    """(P,) smoothed, continued beyond both ends by point reflection, which keeps them."""
    count = min(int(np.ceil(4.0 * sigma)), len(values) - 1)
    before, after = 2.0 * values[0] - values[count:0:-1], 2.0 * values[-1] - values[-2 : -count - 2 : -1]
    smooth = gaussian_filter1d(np.concatenate([before, values, after]), sigma, mode="nearest")
    return np.asarray(smooth[count : count + len(values)])
