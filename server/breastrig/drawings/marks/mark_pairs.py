"""Which small marks on two scans of one patient are the same: proposed, for a person to accept.

The skin map says where each mark on A is expected on B, and how far off that may be.  Pairs are the assignment of the
least total cost (distance in standard deviations, size, colour), and of these the ones that are the best for both their
marks by a margin.  The map then follows them, so that the rest is expected nearer; what contradicts the others is
dropped.

Evidence: docs/decisions/0036.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.drawings.line_error import HOLDS_90, carried_errors
from breastrig.drawings.skin_maps.skin_map import FittedScan, carried, shared_marks, within_reach
from breastrig.rig.model import Rig

ROUNDS = 3
ERROR = 0.02  # m, 90 %, where none is known
OFF_SKIN = 3e-3  # m from the fitted scan: cut away, clothes, the table
OWN_COLOUR = {"nipple_L": 0.025, "nipple_R": 0.025, "umbilicus": 0.015}  # m around, where skin has spots of its own
KNOWN = 6e-3  # m from a mark that the scan has already
SIZE, COLOUR = 0.3, 0.35  # standard deviations: of the logarithm of sizes, of colours as share of their contrast
MOST, MARGIN = 16.0, 6.0  # cost of a pair, and by how much the second best of either mark is worse


@dataclass(frozen=True, eq=False)
class SmallMarks:
    """M small marks on one scan."""

    places: Array  # (M, 3) m on the skin, in the scan's frame
    sizes: Array  # (M,) m
    colours: Array  # (M, 3) Lab, from the skin around to it


@dataclass(frozen=True)
class MarkPair:
    """A mark on A and the same one on B, by their numbers."""

    here: int
    there: int
    off: float  # m, on B from where it was expected
    error: float  # m, 90 % radius of what was expected


def paired(rig: Rig, a: FittedScan, b: FittedScan, on_a: SmallMarks, on_b: SmallMarks) -> tuple[MarkPair, ...]:
    """The pairs, surest first; none of marks that the scans have already.

    Raises BadDrawing for fits off their scans.
    """
    first, second = (np.flatnonzero(followed(rig, scan, marks)) for scan, marks in ((a, on_a), (b, on_b)))
    found: dict[str, MarkPair] = {}
    for _ in range(ROUNDS):
        new = _round(rig, a, b, on_a, on_b, first, second)
        if not new:
            break
        first = np.setdiff1d(first, [pair.here for pair in new])
        second = np.setdiff1d(second, [pair.there for pair in new])
        found |= {f"\0{pair.here}": pair for pair in new}  # no mark of a person has such a name
        a = replace(a, marks=a.marks | {name: on_a.places[pair.here] for name, pair in found.items()})
        b = replace(b, marks=b.marks | {name: on_b.places[pair.there] for name, pair in found.items()})
        for name in {name for name, _ in shared_marks(rig, a, b).asked} & found.keys():
            del found[name], a.marks[name], b.marks[name]
        a, b = replace(a), replace(b)  # other marks, another map
    return tuple(sorted(found.values(), key=lambda pair: pair.off / pair.error))


def followed(rig: Rig, scan: FittedScan, marks: SmallMarks) -> Booleans:
    """(M,) marks on skin that the map follows, neither of areolae and navel nor marked already."""
    if not len(marks.places):
        return np.zeros(0, dtype=np.bool_)
    keep = within_reach(rig, scan.vertices, marks.places)
    keep &= scan.target.search.query(marks.places).distances < OFF_SKIN
    names = tuple(name for name in OWN_COLOUR if name in rig.landmark_names)
    model = rig.landmark_points(names).positions(scan.vertices, rig.faces)
    known = dict(zip(names, model, strict=True)) | scan.known
    for around, place in [
        *((OWN_COLOUR[name], known[name]) for name in names),
        *((KNOWN, p) for p in scan.marks.values()),
    ]:
        keep &= np.linalg.norm(marks.places - place, axis=1) > around
    return keep


def _round(
    rig: Rig, a: FittedScan, b: FittedScan, on_a: SmallMarks, on_b: SmallMarks, first: Integers, second: Integers
) -> list[MarkPair]:
    """The pairs among these numbers of marks."""
    if not len(first) or not len(second):
        return []
    here, there = on_a.places[first], on_b.places[second]
    expected = carried(rig, a, b, here)
    errors = carried_errors(rig, a, b, here, expected, marks=shared_marks(rig, a, b).followed)
    radii = np.full(len(here), ERROR) if errors is None else np.where(np.isfinite(errors), errors, ERROR)
    off = np.linalg.norm(expected[:, None] - there, axis=2)
    cost = (off * HOLDS_90 / radii[:, None]) ** 2 + _unlike(on_a, on_b)[np.ix_(first, second)]
    rows, columns = linear_sum_assignment(np.minimum(cost, MOST))
    rivals = np.minimum(_second(cost)[:, None], _second(cost.T)) - cost
    return [
        MarkPair(int(first[i]), int(second[j]), float(off[i, j]), float(radii[i]))
        for i, j in zip(rows, columns, strict=True)
        if cost[i, j] < MOST and rivals[i, j] >= MARGIN
    ]


def _second(cost: Array) -> Array:
    """(M,) the second least cost of each row; inf where there is but one."""
    if cost.shape[1] < 2:
        return np.full(len(cost), np.inf)
    return np.asarray(np.partition(cost, 1, axis=1)[:, 1])


def _unlike(on_a: SmallMarks, on_b: SmallMarks) -> Array:
    """(M, N) squared standard deviations by which sizes and colours differ."""
    sizes = np.log(on_a.sizes)[:, None] - np.log(on_b.sizes)
    contrast = [np.linalg.norm(marks.colours, axis=1) for marks in (on_a, on_b)]
    apart = np.linalg.norm(on_a.colours[:, None] - on_b.colours, axis=2)
    return np.asarray((sizes / SIZE) ** 2 + (2.0 * apart / (COLOUR * (contrast[0][:, None] + contrast[1]))) ** 2)
