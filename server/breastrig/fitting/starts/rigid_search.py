"""Where the rest pose lies on a scan, from the scan alone: rigid tries all around, the best of them followed further.

Each try is refined by iterative closest points in both directions, in position and normal at once; pairs at the scan's
border or the model's rim do not count.  Tries are judged by capped distances the same two ways.  A scan of a part of a
body is tried to both sides too, one that shows all sides along all six directions of its axes.  Of 38 partial scans of
warped bodies, turned at random, the right place comes first in 36.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.rig.similarity import Similarities, Similarity, nearest_similarities

CELLS = 100_000  # comparisons at once, 0.4 MB: they stay in the processor's cache; four times as many take half again


class NearestPoints:
    """Among fixed (N, D) points, N >= 1."""

    def __init__(self, points: Array) -> None:
        self.points = points
        self._centre = points.mean(axis=0)  # near the origin single precision is finest
        centred = points - self._centre
        products = np.concatenate([-2.0 * centred.T, (centred * centred).sum(axis=1)[None]])
        self._products = products.astype(np.float32)  # (D + 1, N)

    def query(self, places: Array, reach: float) -> tuple[Array, Integers]:
        """Distance and index of the nearest to each of (..., D) places, both (...).

        Where none is nearer than `reach` the distance is inf and the index 0.
        """
        flat = places.reshape(-1, places.shape[-1])
        asked = np.ones((len(flat), len(self._products)), dtype=np.float32)
        np.subtract(flat, self._centre, out=asked[:, :-1], casting="same_kind")
        nearest = np.zeros(len(flat), dtype=np.int64)
        rows = max(1, CELLS // len(self.points))
        table = np.zeros((rows, len(self.points)), dtype=np.float32)
        for first in range(0, len(flat), rows):
            part = asked[first : first + rows]
            compared = table[: len(part)]
            np.matmul(part, self._products, out=compared)
            compared.argmin(axis=1, out=nearest[first : first + rows])
        gaps = self.points.take(nearest, axis=0)
        gaps -= flat
        distances = np.sqrt(np.einsum("md,md->m", gaps, gaps))
        beyond = ~(distances < reach)
        distances[beyond], nearest[beyond] = np.inf, 0
        return distances.reshape(places.shape[:-1]), nearest.reshape(places.shape[:-1])


SCALE = (0.85, 1.15)  # of the rest pose; the fit itself may go further
NORMAL_LENGTH = 0.06  # m a unit of normal counts as: skin facing away by 60 degrees is as far as skin 6 cm off
CAP = 0.06  # m; beyond it a distance says only "elsewhere"
KERNEL = 0.03  # m, of the steps' weights; what a rest pose is off on a patient
EDGE = 0.012  # m from scan's border or model's rim; the spacing of the points that are compared
AT_EDGE = 0.5 * CAP  # m; what a pair that ends at an edge counts as at least: nobody knows
COVER_WEIGHT = 0.3  # of model to scan against scan to model: scans end where they end
FEWEST_PAIRS = 40  # of a step; fewer would turn the body towards a scrap
HEIGHTS = 5  # from the scan's lower to its upper end
TURNS = 24  # around the front: every 15 degrees, the basin is about 20 wide on each side
PART_TURNS = 12  # with sidewards tries beside them fewer do: 11 of 12 partial scans either way
PART_YAWS = (-0.7, 0.0, 0.7)  # rad; the front of half a body is read up to 50 degrees wrong
PART_SHIFTS = (-0.09, 0.0, 0.09)  # m; half of half a body's width
UNCOVERED = 0.034  # m, model to scan; whole scans have 0.021 to 0.031, partial ones 0.037 to 0.049
OTHER_TURN = 0.7  # rad; a try turned farther than this is another position
FEW_KEPT = 10  # tries at least, for each direction that the front may have
OTHERS_KEPT = 3  # tries in other positions, so that the margin is measured as well as the score
COARSE = ((0.12, 1, 0.25), (0.12, 2, 0.3), (0.10, 3, 0.5))  # m a pair may be apart, steps, share of the tries kept
FINE_REACH, FINE_STEPS = 0.08, 6  # m, steps; more move nothing


@dataclass(frozen=True, eq=False)
class Place:
    """Of the rest pose on a scan."""

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

    def __init__(self, rig: Rig, target: ScanTarget, model: tuple[int, int], scan: tuple[int, int]) -> None:
        """`model`, `scan`: about so many points that look for their nearest, and so many that are looked among."""
        normals = vertex_normals(rig.template, rig.faces)
        rim = rig.template[boundary_vertices(rig.faces, len(rig.template))]
        self.asking, self.asking_normals = (each[_thinned(len(each), model[0])] for each in (rig.template, normals))
        asked = _thinned(len(normals), model[1])
        self.model, self.at_rim = rig.template[asked], _near(rim, rig.template[asked])
        self._model_points = NearestPoints(np.hstack([self.model, NORMAL_LENGTH * normals[asked]]))
        seen = _thinned(len(target.vertices), scan[0])
        self.seen, self.seen_normals = target.vertices[seen], target.normals[seen]
        asked = _thinned(len(target.vertices), scan[1])
        self.scan = target.vertices[asked]
        self.at_border = _near(target.vertices[target.on_border], self.scan)
        self._scan_points = NearestPoints(np.hstack([self.scan, NORMAL_LENGTH * target.normals[asked]]))

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

    def moved(self, tries: Similarities, reach: float) -> Similarities:
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
        found = nearest_similarities(source, goals, used / (1.0 + (gaps / KERNEL) ** 2), SCALE)
        return tries.where(used.sum(axis=1) < FEWEST_PAIRS, found)

    def scores(self, tries: Similarities) -> tuple[Array, Array]:
        """(T,), (T,) m: the scores, and how far the model is from the scan."""
        back, on_model = self._to_model(tries, CAP / SCALE[0])
        back = np.minimum(back * tries.scales[:, None], CAP)
        back = np.where(self.at_rim[on_model], np.maximum(back, AT_EDGE), back).mean(axis=1)
        there, on_scan = self._to_scan(tries, CAP)
        there = np.minimum(there, CAP)
        there = np.where(self.at_border[on_scan], np.maximum(there, AT_EDGE), there).mean(axis=1)
        return back + COVER_WEIGHT * there, there


def _thinned(size: int, wanted: int) -> slice:
    return slice(None, None, max(1, size // wanted))


def _near(edge: Array, points: Array) -> Booleans:
    """(M,) of the (M, 3) points, which lie within EDGE of a point of the edge."""
    if not len(edge):
        return np.zeros(len(points), dtype=np.bool_)
    gaps, _ = cKDTree(edge).query(points, distance_upper_bound=EDGE)
    return np.isfinite(gaps)


def _nearest(points: NearestPoints, places: Array, reach: float) -> tuple[Array, Integers]:
    """Distance (2 reach where there is none within reach) and index, as the places without their last axis."""
    gaps, nearest = points.query(places, reach)
    return np.minimum(gaps, 2.0 * reach), nearest


def rest_place(rig: Rig, target: ScanTarget, fronts: Array) -> Place:
    """The best place for a scan whose front is about one of (N, 3) unit directions."""
    thinned = target.vertices[:: max(1, len(target.vertices) // 2000)]
    turns = [turn for front in fronts for turn in _turns(front, TURNS)]
    tries = _starts(rig, thinned, np.array(turns), (0.0,))
    found = _searched(rig, target, tries, FEW_KEPT * len(fronts))
    if found.shows_a_part:
        found = min(found, _place_of_part(rig, target, thinned, fronts), key=lambda place: place.score)
    return found


def _place_of_part(rig: Rig, target: ScanTarget, thinned: Array, fronts: Array) -> Place:
    """With tries to both sides of the front and of the middle."""
    yawed = [
        turn @ exp_so3(np.array([0.0, yaw, 0.0]))
        for front in fronts
        for turn in _turns(front, PART_TURNS)
        for yaw in PART_YAWS
    ]
    tries = _starts(rig, thinned, np.array(yawed), PART_SHIFTS)
    return _searched(rig, target, tries, FEW_KEPT * len(fronts))


def _turns(front: Array, turns: int) -> list[Array]:
    """(3, 3) body axes (left, up, front as columns) all around a (3,) front."""
    guess = np.eye(3)[np.abs(front).argmin()]
    first = guess - (guess @ front) * front
    first /= np.linalg.norm(first)
    ups = [exp_so3(angle * front) @ first for angle in np.arange(turns) * (2.0 * np.pi / turns)]
    return [np.column_stack([np.cross(up, front), up, front]) for up in ups]


def _starts(rig: Rig, scan: Array, rotations: Array, shifts: tuple[float, ...]) -> list[Similarity]:
    """The rest pose in each of (T, 3, 3) axes, at several heights, beside the middle of a (V, 3) scan, at its front."""
    local = np.ascontiguousarray((scan @ rotations).transpose(2, 0, 1))  # (3, T, V)
    low, high = np.percentile(local[1:], [1, 99], axis=2)  # (2, T) each, of heights and depths
    body_low, body_high = rig.template.min(axis=0), rig.template.max(axis=0)
    ends = np.sort([high[0] - body_high[1] - 0.2, low[0] - body_low[1] + 0.1], axis=0)
    heights = np.linspace(ends[0], ends[1], HEIGHTS).T  # (T, HEIGHTS)
    parts = zip(rotations, np.median(local[0], axis=1), heights, high[1] - body_high[2], strict=True)
    return [
        Similarity(1.0, rotation, rotation @ np.array([middle + shift, height, front]))
        for rotation, middle, levels, front in parts
        for shift in shifts
        for height in levels
    ]


def _searched(rig: Rig, target: ScanTarget, starts: list[Similarity], few: int) -> Place:
    """The best place that the tries come to."""
    tries = Similarities.of(starts)
    coarse = _Comparison(rig, target, model=(50, 600), scan=(80, 1500))
    for reach, steps, share in COARSE:
        for _ in range(steps):
            tries = coarse.moved(tries, reach)
        scores, _ = coarse.scores(tries)
        tries = tries.chosen(_kept(tries, scores, max(few, int(share * len(scores)))))
    fine = _Comparison(rig, target, model=(220, 1200), scan=(350, 3000))
    for _ in range(FINE_STEPS):
        tries = fine.moved(tries, FINE_REACH)
    scores, uncovered = fine.scores(tries)
    first = int(scores.argmin())
    others = scores[_turned_away(tries, first)]
    margin = float(others.min() / max(scores[first], 1e-9)) - 1.0 if len(others) else 1.0
    return Place(tries.one(first), float(scores[first]), margin, float(uncovered[first]))


def _kept(tries: Similarities, scores: Array, count: int) -> Integers:
    """Indices of the best, and of the best that are turned away from the first of them."""
    order = np.argsort(scores, kind="stable")
    away = order[_turned_away(tries, int(order[0]))[order]]
    return np.unique(np.concatenate([order[:count], away[:OTHERS_KEPT]]))


def _turned_away(tries: Similarities, first: int) -> Booleans:
    """(T,) which of the tries are another position than the first."""
    traces = np.einsum("tij,ij->t", tries.rotations, tries.rotations[first])
    return np.asarray(traces < 1.0 + 2.0 * np.cos(OTHER_TURN))
