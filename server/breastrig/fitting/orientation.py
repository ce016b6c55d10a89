"""Where a fit starts: on its landmarks, or where the scan itself says which way is up and what of the body it shows.

Landmarks are met by a similarity that trusts the majority (iteratively reweighted Umeyama), so that one pick on the
wrong place or two exchanged sides do not turn it.

Without them the front is known (scan/orient.py reads it from what the camera saw, to about ten degrees); the turn
around it and the height are not.  So the rest pose is tried at every turn and several heights, each followed by a few
rigid steps of iterative closest points on few vertices, scored by capped distances both ways (model to scan, so that
it lies on skin; scan to model, so that it covers the skin there is), and the best few are followed further.
On the ten dev scans, turned at random, the right turn wins by 15 % to 25 % of the score over the next basin.
A scan that shows all sides has no known front: then all six directions of its axes are tried (1 s instead of 0.2);
torsos are found so, bodies with head and thighs not always: their margin is small.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.similarity import Similarities, Similarity, nearest_similarities, similar_parameters, umeyama
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

TRUST = 0.04  # m; patients' landmarks lie within about 3 cm of a similarity of the model's
ADULT_SCALE = (0.75, 1.3)  # of the model
MIN_LANDMARKS = 3  # fewer leave the similarity open
CAP = 0.05  # m; beyond it a distance says only "elsewhere"
REACH = 0.08  # m; how far a step looks for skin
TURNS = 24  # around the front: every 15 degrees, the basin is about 20 wide on each side
HEIGHTS = 5  # from the scan's lower to its upper end
COARSE_MODEL, COARSE_SCAN, COARSE_STEPS = 220, 3000, 5  # vertices of the model and of the scan, steps of a try
FINE_MODEL, FINE_STEPS = 500, 12  # on the whole scan
LEAF = 32  # points; a seventh faster than SciPy's 16 at this size
FOLLOWED = 4  # tries worth the fine steps, for each direction that the front may have
FACING = 0.35  # cosine; 70 degrees between the normals still count as the same side
SURE_LANDMARKS = 6  # so many never lie on one line
AGREED = 0.08  # m, mean distance of the landmarks to a start that they agree with; the dev scans' are under 5 cm
SCALE = (0.85, 1.15)  # of the rest pose; the fit itself may go further
FEWEST_PAIRS = 20  # of a step; fewer would turn the body towards a scrap


def trusted_similarity(model: Array, picked: Array) -> tuple[Similarity, Array]:
    """A similarity that the majority of the (L, 3) pairs agree on, and the (L,) residuals in m."""
    found = umeyama(model, picked)
    residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    for scale in (4.0 * TRUST, 2.0 * TRUST, TRUST, TRUST, TRUST):
        found = umeyama(model, picked, 1.0 / (1.0 + (residual / scale) ** 2) ** 2)
        residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    return found, residual


def start_from_landmarks(rig: Rig, landmarks: dict[str, Array]) -> RigParameters:
    """The rest pose on three or more landmarks (3,) m; the scale is kept within what adults have."""
    names = tuple(landmarks)
    model = rig.landmark_points(names).positions(rig.template, rig.faces)
    picked = np.array([landmarks[name] for name in names])
    found, residual = trusted_similarity(model, picked)
    scale = float(np.clip(found.scale, *ADULT_SCALE))
    share = 1.0 / (1.0 + (residual / TRUST) ** 2) ** 2
    shift = share @ (picked - scale * model @ found.rotation.T) / share.sum()
    return similar_parameters(rig, Similarity(scale, found.rotation, shift))


@dataclass(frozen=True, eq=False)
class Start:
    """A rest pose on a scan."""

    parameters: RigParameters
    similarity: Similarity  # of the rest pose
    rotation: Array  # (3, 3) columns: the body's left, up and front in the scan's axes
    score: float  # m, mean capped distance both ways; smaller is better
    margin: float  # how much worse the best try in another turn is, as a share of the score


class _Tries:
    """Rigid tries on one scan, all followed at once: one by one the calls would cost more than the work."""

    def __init__(self, rig: Rig, target: ScanTarget, vertices: int, scan_vertices: int | None) -> None:
        """With about so many vertices of the model, and of the scan (None: all)."""
        chosen = np.arange(0, len(rig.template), max(1, len(rig.template) // vertices))
        self.source = rig.template[chosen]
        self.normals = vertex_normals(rig.template, rig.faces)[chosen]
        thinned = slice(None, None, 1 if scan_vertices is None else max(1, len(target.vertices) // scan_vertices))
        self.scan, self.scan_normals = target.vertices[thinned], target.normals[thinned]
        self.tree = target.vertex_tree if scan_vertices is None else cKDTree(self.scan, leafsize=LEAF)
        self.sample = target.vertices[:: max(1, len(target.vertices) // 800)]

    def _pairs(self, tries: Similarities) -> tuple[Booleans, Integers, Array]:
        """(T, M) of T tries and M vertices of the model: accepted, index of the scan's vertex, distance (m)"""
        answer = self.tree.query(tries.apply(self.source), distance_upper_bound=REACH)
        distances, nearest = np.asarray(answer[0]), np.asarray(answer[1], dtype=np.int64)
        hit = nearest < len(self.scan)
        nearest[~hit] = 0
        turned = self.normals @ tries.rotations.transpose(0, 2, 1)
        hit &= np.einsum("tmi,tmi->tm", turned, self.scan_normals[nearest]) > FACING
        return hit, nearest, distances

    def followed(self, tries: Similarities, steps: int) -> tuple[Array, Similarities]:
        """(T,) scores (m) of the tries after some steps, and where they came to."""
        for _ in range(steps):
            hit, nearest, _ = self._pairs(tries)
            stays = hit.sum(axis=1) < FEWEST_PAIRS
            tries = tries.where(stays, nearest_similarities(self.source, self.scan[nearest], hit, SCALE))
        hit, _, distances = self._pairs(tries)
        there = np.where(hit, np.minimum(distances, CAP), CAP).mean(axis=1)
        body = cKDTree(self.source)  # the scan comes to the body: nearest points stay nearest under a similarity
        back, _ = body.query(tries.undone(self.sample), distance_upper_bound=CAP / SCALE[0])
        return there + np.minimum(np.asarray(back) * tries.scales[:, None], CAP).mean(axis=1), tries


def _starts(rig: Rig, target: ScanTarget, rotation: Array) -> list[Similarity]:
    """The rest pose in these axes at several heights, in the middle of the scan and at its front."""
    local = target.vertices[:: max(1, len(target.vertices) // 5000)] @ rotation
    low, high = np.percentile(local, [1, 99], axis=0)
    body_low, body_high = rig.template.min(axis=0), rig.template.max(axis=0)
    ends = sorted((high[1] - body_high[1] - 0.2, low[1] - body_low[1] + 0.1))
    places = [
        np.array([np.median(local[:, 0]), y, high[2] - body_high[2]]) for y in np.linspace(ends[0], ends[1], HEIGHTS)
    ]
    return [Similarity(1.0, rotation, rotation @ place) for place in places]


def _turns(front: Array) -> list[Array]:
    """(3, 3) body axes (left, up, front as columns) all around a (3,) front."""
    guess = np.eye(3)[np.abs(front).argmin()]
    first = guess - (guess @ front) * front
    first /= np.linalg.norm(first)
    ups = [exp_so3(angle * front) @ first for angle in np.arange(TURNS) * (2.0 * np.pi / TURNS)]
    return [np.column_stack([np.cross(up, front), up, front]) for up in ups]


def start_from_scan(rig: Rig, target: ScanTarget, fronts: Array) -> Start:
    """The best rest pose for a scan whose front is about one of (N, 3) unit directions."""
    begun = [start for front in fronts for rotation in _turns(front) for start in _starts(rig, target, rotation)]
    scores, found = _Tries(rig, target, COARSE_MODEL, COARSE_SCAN).followed(Similarities.of(begun), COARSE_STEPS)
    order = np.argsort(scores, kind="stable")
    best_few = found.chosen(order[: FOLLOWED * len(fronts)])
    fine_scores, fine = _Tries(rig, target, FINE_MODEL, None).followed(best_few, FINE_STEPS)
    first = int(fine_scores.argmin())
    best = fine.one(first)
    other = scores[np.einsum("tij,ij->t", found.rotations, best.rotation) < 1.0 + 2.0 * np.cos(0.7)]
    margin = float(other.min()) / max(float(scores.min()), 1e-9) - 1.0 if len(other) else 1.0
    return Start(similar_parameters(rig, best), best, best.rotation, float(fine_scores[first]), margin)


def best_start(
    rig: Rig,
    target: ScanTarget,
    landmarks: dict[str, Array],
    fronts: Callable[[], Array],
    known: Similarity | None = None,
) -> RigParameters:
    """The start for these landmarks ((3,) m by name) on a scan whose front is about one of (N, 3) directions.

    `known` is what start_from_scan has found for the scan before; it and `fronts` are needed only where landmarks do
    not say enough.

    Six and more landmarks place the body alone.  Three to five may lie nearly on a line (the breastbone, both
    collar bones and the notch) and leave a turn open: then the scan's own start is taken, if the landmarks agree.
    """

    def from_scan() -> RigParameters:
        return start_from_scan(rig, target, fronts()).parameters if known is None else similar_parameters(rig, known)

    if len(landmarks) < MIN_LANDMARKS:
        return from_scan()
    by_landmarks = start_from_landmarks(rig, landmarks)
    if len(landmarks) >= SURE_LANDMARKS:
        return by_landmarks
    by_scan = from_scan()
    names = tuple(landmarks)
    places = rig.landmark_points(names).positions(pose(rig, by_scan), rig.faces)
    gaps = np.linalg.norm(places - np.array([landmarks[name] for name in names]), axis=1)
    return by_scan if gaps.mean() < AGREED else by_landmarks
