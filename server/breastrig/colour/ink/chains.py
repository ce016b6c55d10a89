"""Joins things into chains by their ends: neighbours along a line, then ends of lines across gaps and crossings.

Both are the same question: which two free ends belong together? Every end proposes its cheapest partner, those that
choose each other are joined, and the rest propose again. All distances are in space, so neither the seams of the
scanner's texture nor those between our pictures matter.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers


@dataclass(frozen=True, eq=False)
class Joints:
    """L possible joints of two ends; each end is joined once at most."""

    first: Integers  # (L,) number of an end
    second: Integers  # (L,)
    cost: Array  # (L,)


def chosen(joints: Joints, ends: int) -> Booleans:
    """(L,) the joints that are made between `ends` ends: the cheapest of both their ends, round after round."""
    made = np.zeros(len(joints.cost), dtype=np.bool_)
    order = np.argsort(joints.cost, kind="stable")
    first, second = joints.first[order], joints.second[order]
    open_ = np.arange(len(order))
    while len(open_):
        best = np.full(ends, len(order))
        np.minimum.at(best, first[open_], open_)
        np.minimum.at(best, second[open_], open_)
        agreed = open_[(best[first[open_]] == open_) & (best[second[open_]] == open_)]
        made[order[agreed]] = True
        taken = np.zeros(ends, dtype=np.bool_)
        taken[first[agreed]] = taken[second[agreed]] = True
        open_ = open_[~(taken[first[open_]] | taken[second[open_]])]
    return made


def neighbours_joined(places: Array, tangents: Array, reach: float, turn: float) -> list[tuple[Integers, bool]]:
    """Chains of at least two of (M, 3) m places with (M, 3) tangents: their numbers in order, and whether closed.

    Neighbours lie within `reach` (m), and lines turn from one to the next by less than acos `turn`.
    """
    pairs = cKDTree(places).query_pairs(reach, output_type="ndarray")
    one, other = pairs.T.astype(np.int64)
    way = places[other] - places[one]
    length = np.sqrt(np.einsum("mi,mi->m", way, way))
    way /= np.maximum(length, 1e-12)[:, None]
    at_one, at_other = (np.einsum("mi,mi->m", way, tangents[each]) for each in (one, other))
    same = np.abs(np.einsum("mi,mi->m", tangents[one], tangents[other]))
    straight = np.minimum(np.minimum(np.abs(at_one), np.abs(at_other)), same)
    good = straight > turn
    one, other, straight, length = one[good], other[good], straight[good], length[good]
    # the end 2 i + 1 is the one where the tangent of i leads out, 2 i the other
    joints = Joints(2 * one + (at_one[good] > 0), 2 * other + (at_other[good] < 0), length * (3.0 - 2.0 * straight))
    made = chosen(joints, 2 * len(places))
    first, second = joints.first[made], joints.second[made]
    used = np.unique(np.concatenate([first, second]) // 2)  # most are grain and have no neighbour
    number = np.zeros(len(places), dtype=np.int64)
    number[used] = np.arange(len(used))
    chains = walked(2 * number[first // 2] + first % 2, 2 * number[second // 2] + second % 2, len(used))
    return [(used[[each for each, _ in chain]], closed) for chain, closed in chains]


def walked(first: Integers, second: Integers, count: int) -> list[tuple[list[tuple[int, bool]], bool]]:
    """All chains of `count` things, joined at their ends (2 i, 2 i + 1).

    Each is ([(number, whether it is gone through from its end 2 i + 1), ...], closed); a thing that is joined to
    nothing is a chain of its own.
    """
    partner = np.full(2 * count, -1, dtype=np.int64)
    partner[first], partner[second] = second, first
    mate = partner.tolist()
    seen = bytearray(count)
    chains = []
    free = np.flatnonzero(partner < 0).tolist()
    for closed, starts in ((False, free), (True, range(2 * count))):
        for start in starts:
            chain, end = [], start  # entered by this end
            while end >= 0 and not seen[end // 2]:
                seen[end // 2] = 1
                chain.append((end // 2, end % 2 == 1))
                end = mate[end ^ 1]
            if chain:
                chains.append((chain, closed))
    return chains
