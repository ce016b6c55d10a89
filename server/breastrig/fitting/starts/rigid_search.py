"""Finds the rest pose's place on a scan, from the scan alone: rigid tries all around, the best of them refined.

Each try is refined by iterative closest points in both directions, in position and normal at once; pairs at the scan's
border or the model's rim do not count. Tries are judged by capped distances in both directions, at levels that grow
finer. All are turned to both sides of the front and moved to both sides of the middle too, as parts need; a scan that
shows all sides is tried along all six directions of its axes. Of 120 scans and parts of warped bodies 118 are placed
right (docs/decisions/0009).
"""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.similarity import Similarities, Similarity, nearest_similarities

LEAF = 64  # points, of a tree that is asked some thousand times: half the time of 16
SCALE = (0.85, 1.4)  # of the rest pose; heavy women's trunks are 1.15 to 1.4 times as large
NORMAL_LENGTH = 0.06  # m a unit of normal counts as: skin facing away by 60 degrees is as far as skin 6 cm off
CAP = 0.06  # m; beyond it a distance says only "elsewhere"
KERNEL = 0.03  # m, of the steps' weights; what a rest pose is off on a patient
EDGE = 0.012  # m from scan's border or model's rim; the spacing of the points that are compared
AT_EDGE = 0.5 * CAP  # m; what a pair that ends at an edge counts as at least: nobody knows
COVER_WEIGHT = 0.3  # of model to scan against scan to model: scans end where they end
FEWEST_PAIRS = 40  # of a step; fewer would turn the body towards a scrap
HEIGHT = 0.075  # m between tries along the body
TURNS = 12  # around the front: every 30 degrees, the basin is about 20 wide on each side
YAWS = (-0.7, 0.0, 0.7)  # rad; the front of half a body is read up to 50 degrees wrong
MIDDLE = 0.12  # m to the sides of it, where the front is looked for
SHIFTS = (-0.09, 0.0, 0.09)  # m to the sides; half of half a body's width
UNCOVERED = 0.034  # m, model to scan; whole scans have 0.021 to 0.031, partial ones 0.037 to 0.049
OTHER_TURN = 0.7  # rad; a try turned farther than this is another position
OBLIQUE = 1.05  # rad; patients lie up to 0.5 turned in a scanner, and beyond this left, up or front may be reversed
ASIDE = (-0.5, 0.0, 0.5)  # rad, about each axis, of tries beside axes that are known
OTHERS_KEPT = 3  # tries in other positions, so that the margin is measured as well as the score


class Level(NamedTuple):
    """Settings by which the remaining tries are moved and judged at one level."""

    model: tuple[int, int]  # so many of the model's points look for their nearest, about, and are looked among
    scan: tuple[int, int]  # likewise the scan's
    reach: float  # m a pair may be apart
    steps: int
    kept: int  # tries, for each direction that the front may have


LEVELS = (
    Level((16, 200), (30, 500), 0.12, 1, 80),
    Level((30, 400), (50, 1000), 0.12, 2, 24),
    Level((50, 600), (80, 1500), 0.10, 3, 8),
    Level((120, 900), (200, 2000), 0.08, 2, 3),
    Level((220, 1200), (350, 3000), 0.08, 3, 3),  # more steps move nothing
)


@dataclass(frozen=True, eq=False)
class Place:
    """A place of the rest pose on a scan."""

    similarity: Similarity
    score: float  # m; smaller is better
    margin: float  # how much worse the best try in another position is, as a share of the score
    uncovered: float  # m, model to scan, capped; much of it where the scan shows a part

    @property
    def shows_a_part(self) -> bool:
        """Whether the scan leaves much of the model without skin."""
        return self.uncovered > UNCOVERED


class _Comparison:
    """A rest pose and a scan, thinned: pairs, steps and scores of many tries at once."""

    def __init__(self, model: "_Points", scan: "_Points", level: Level) -> None:
        asking, seen = model.thinned(level.model[0]), scan.thinned(level.scan[0])
        self.asking, self.asking_normals, self.seen, self.seen_normals = *asking[:2], *seen[:2]
        self.model, normals, self.at_rim = model.thinned(level.model[1])
        self._model_points = _tree(self.model, normals)
        self.scan, normals, self.at_border = scan.thinned(level.scan[1])
        self._scan_points = _tree(self.scan, normals)

    def _to_model(self, tries: Similarities, reach: float) -> tuple[Array, Integers]:
        """(T, K) m and indices: the model's nearest to each of the scan's points, which come to the model."""
        places = np.concatenate(
            [tries.undone(self.seen), NORMAL_LENGTH * (self.seen_normals @ tries.rotations)], axis=2
        )
        return _nearest(self._model_points, places, reach)

    def _to_scan(self, tries: Similarities, reach: float) -> tuple[Array, Integers]:
        """(T, M) m and indices: the scan's nearest to each of the model's points."""
        turned = self.asking_normals @ tries.rotations.transpose(0, 2, 1)
        return _nearest(
            self._scan_points, np.concatenate([tries.apply(self.asking), NORMAL_LENGTH * turned], axis=2), reach
        )

    def moved(self, tries: Similarities, reach: float, scales: tuple[float, float]) -> Similarities:
        """After one step of closest points both ways, over pairs within `reach` (m) that do not end at an edge."""
        back, on_model = self._to_model(tries, reach)
        there, on_scan = self._to_scan(tries, reach)
        gaps = np.concatenate([back, there], axis=1)
        used = (gaps < reach) & ~np.concatenate([self.at_rim[on_model], self.at_border[on_scan]], axis=1)
        count = len(gaps)
        source = np.concatenate(
            [self.model[on_model], np.broadcast_to(self.asking, (count, *self.asking.shape))], axis=1
        )
        goals = np.concatenate([np.broadcast_to(self.seen, (count, *self.seen.shape)), self.scan[on_scan]], axis=1)
        found = nearest_similarities(source, goals, used / (1.0 + (gaps / KERNEL) ** 2), scales)
        return tries.where(used.sum(axis=1) < FEWEST_PAIRS, found)

    def scores(self, tries: Similarities) -> tuple[Array, Array]:
        """(T,), (T,) m: the scores, and how far the model is from the scan."""
        back, on_model = self._to_model(tries, CAP / float(tries.scales.min()))
        back = np.minimum(back * tries.scales[:, None], CAP)
        back = np.where(self.at_rim[on_model], np.maximum(back, AT_EDGE), back).mean(axis=1)
        there, on_scan = self._to_scan(tries, CAP)
        there = np.minimum(there, CAP)
        there = np.where(self.at_border[on_scan], np.maximum(there, AT_EDGE), there).mean(axis=1)
        return back + COVER_WEIGHT * there, there


class _Points:
    """Places (N, 3) m with their (N, 3) normals, and which of them lie within EDGE of the (N,) ones on an edge."""

    def __init__(self, places: Array, normals: Array, on_edge: Booleans) -> None:
        self._places, self._normals = places, normals
        self._edge = cKDTree(places[on_edge]) if on_edge.any() else None

    def thinned(self, wanted: int) -> tuple[Array, Array, Booleans]:
        """About so many of them."""
        some = slice(None, None, max(1, len(self._places) // wanted))
        places = self._places[some]
        if self._edge is None:
            return places, self._normals[some], np.zeros(len(places), dtype=np.bool_)
        return places, self._normals[some], np.isfinite(self._edge.query(places, distance_upper_bound=EDGE)[0])


def _tree(points: Array, normals: Array) -> cKDTree:
    return cKDTree(np.hstack([points, NORMAL_LENGTH * normals]), LEAF, compact_nodes=False, balanced_tree=False)


def _nearest(points: cKDTree, places: Array, reach: float) -> tuple[Array, Integers]:
    """Distance and index, as the places without their last axis; where there is none within reach 2 reach and 0."""
    gaps, nearest = points.query(places, distance_upper_bound=reach)
    return np.minimum(gaps, 2.0 * reach), np.where(np.isfinite(gaps), nearest, 0)


def rest_place(
    body: Array, faces: Integers, target: ScanTarget, turns: Array, scale: float = 1.0, known: Array | None = None
) -> Place:
    """The best place of a rest pose (V, 3) m for a scan of a body whose axes are about one of (T, 3, 3).

    The body is about `scale` times as large, and lies at most OBLIQUE from its (3, 3) axes where they are `known`.
    """
    thinned = target.vertices[:: max(1, len(target.vertices) // 2000)]
    tries = Similarities.of(_starts(body, thinned, turns, scale))
    share = max(len(turns) / (TURNS * len(YAWS)), 1.0)  # of those of a single front
    scales = SCALE[0] * scale, SCALE[1] * scale
    model = _Points(body, vertex_normals(body, faces), boundary_vertices(faces, len(body)))
    scan = _Points(target.vertices, target.normals, target.on_border)
    for level in LEVELS:
        comparison = _Comparison(model, scan, level)
        for _ in range(level.steps):
            moved = comparison.moved(tries, level.reach, scales)
            tries = moved if known is None else tries.where(turned_from(moved.rotations, known, OBLIQUE), moved)
        scores, uncovered = comparison.scores(tries)
        kept = _kept(tries, scores, int(level.kept * share))
        tries, scores, uncovered = tries.chosen(kept), scores[kept], uncovered[kept]
    first = int(scores.argmin())
    others = scores[_turned_away(tries, first)]
    margin = float(others.min() / max(scores[first], 1e-9)) - 1.0 if len(others) else 1.0
    return Place(tries.one(first), float(scores[first]), margin, float(uncovered[first]))


def turns_to(fronts: Array) -> Array:
    """(T, 3, 3) body axes (left, up, front as columns) all around (N, 3) fronts, and turned a little to their sides."""
    yawed = [exp_so3(np.array([0.0, yaw, 0.0])) for yaw in YAWS]
    return np.array([turn @ yaw for front in fronts for turn in _turns(front) for yaw in yawed])


def turns_beside(known: Array) -> Array:
    """(T, 3, 3) body axes at known (3, 3) ones and obliquely beside them."""
    return np.array([known @ exp_so3(np.array(aside)) for aside in product(ASIDE, repeat=3)])


def turned_from(rotations: Array, axes: Array, angle: float) -> Booleans:
    """(...,) which of (..., 3, 3) rotations are turned from (3, 3) axes by more than an angle in rad."""
    return np.asarray(np.einsum("...ij,ij->...", rotations, axes) < 1.0 + 2.0 * np.cos(angle))


def turns_about(up: Array) -> Array:
    """(T, 3, 3) body axes all around a (3,) unit direction."""
    return np.array([turn[:, [1, 2, 0]] for turn in _turns(up)])  # its "front" is up here, its "up" is left


def _turns(front: Array) -> list[Array]:
    """(3, 3) body axes (left, up, front as columns) all around a (3,) front."""
    guess = np.eye(3)[np.abs(front).argmin()]
    first = guess - (guess @ front) * front
    first /= np.linalg.norm(first)
    ups = [exp_so3(angle * front) @ first for angle in np.arange(TURNS) * (2.0 * np.pi / TURNS)]
    return [np.column_stack([np.cross(up, front), up, front]) for up in ups]


def _starts(body: Array, scan: Array, rotations: Array, scale: float) -> list[Similarity]:
    """The rest pose in each of (T, 3, 3) axes, from the lower to the upper end of a (V, 3) scan, at its front."""
    local = np.ascontiguousarray((scan @ rotations).transpose(2, 0, 1))  # (3, T, V)
    low, high = np.percentile(local[1], [1, 99], axis=1)  # (T) each, of heights
    middles = np.median(local[0], axis=1)
    near = np.abs(local[0] - middles[:, None]) < MIDDLE  # not the hands before the body
    near |= ~near.any(axis=1, keepdims=True)  # a surface may have no vertex in its middle
    depths = np.sort(np.where(near, local[2], -np.inf), axis=1)
    fronts = depths[np.arange(len(depths)), len(scan) - 1 - near.sum(axis=1) // 100]
    body_low, body_high = scale * body.min(axis=0), scale * body.max(axis=0)
    ends = np.sort([high - body_high[1] - 0.2, low - body_low[1] + 0.1], axis=0).T
    heights = [np.linspace(first, last, max(2, 1 + round((last - first) / HEIGHT))) for first, last in ends]
    parts = zip(rotations, middles, heights, fronts - body_high[2], strict=True)
    return [
        Similarity(scale, rotation, rotation @ np.array([middle + shift, height, front]))
        for rotation, middle, levels, front in parts
        for shift in SHIFTS
        for height in levels
    ]


def _kept(tries: Similarities, scores: Array, count: int) -> Integers:
    """Indices of the best, and of the best that are turned away from the first of them."""
    order = np.argsort(scores, kind="stable")
    away = order[_turned_away(tries, int(order[0]))[order]]
    return np.unique(np.concatenate([order[:count], away[:OTHERS_KEPT]]))


def _turned_away(tries: Similarities, first: int) -> Booleans:
    """(T,) which of the tries are another position than the first."""
    return turned_from(tries.rotations, tries.rotations[first], OTHER_TURN)
