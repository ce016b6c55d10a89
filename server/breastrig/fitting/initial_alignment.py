"""Where a fit starts: a similarity from landmarks, or from the scan's frame and position alone.

Umeyama, Least-squares estimation of transformation parameters between two point patterns, 1991.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.core.errors import BadLandmarks
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters

MIN_LANDMARKS = 3  # fewer leave the similarity open
CAP = 0.05  # m; beyond it a distance says only "elsewhere"


@dataclass(frozen=True, eq=False)
class Similarity:
    """x -> scale * rotation @ x + translation"""

    scale: float
    rotation: Array  # (3, 3)
    translation: Array  # (3,) m

    def apply(self, points: Array) -> Array:
        """(M, 3) -> (M, 3)"""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)


def umeyama(source: Array, target: Array) -> Similarity:
    """The similarity (no reflection) that carries (M, 3) source points to target points best; M >= 3."""
    mean_s, mean_t = source.mean(axis=0), target.mean(axis=0)
    centred_s, centred_t = source - mean_s, target - mean_t
    u, d, vt = np.linalg.svd(centred_t.T @ centred_s)
    if d[1] < 1e-6 * max(d[0], 1e-30):
        raise BadLandmarks("The landmarks lie on one line; pick at least three that do not.")
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = (u * signs) @ vt
    scale = float((d * signs).sum() / (centred_s**2).sum())
    return Similarity(scale, rotation, mean_t - scale * rotation @ mean_s)


def similar_parameters(rig: Rig, similarity: Similarity) -> RigParameters:
    """The rest pose carried by a similarity: its scale goes into every bone."""
    rest = rest_parameters(rig)
    return RigParameters(
        rotations=similarity.rotation @ rest.rotations,
        translations=similarity.apply(rest.translations),
        scales=np.full_like(rest.scales, similarity.scale),
        weights=rest.weights,
    )


def start_from_landmarks(rig: Rig, landmarks: dict[str, Array]) -> RigParameters:
    """The rest pose on three or more landmarks (3,) m; the scale is kept within what adults have."""
    names = tuple(landmarks)
    model = rig.landmark_points(names).positions(rig.template, rig.faces)
    picked = np.array([landmarks[name] for name in names])
    found = umeyama(model, picked)
    scale = float(np.clip(found.scale, 0.75, 1.3))
    translation = picked.mean(axis=0) - scale * found.rotation @ model.mean(axis=0)
    return similar_parameters(rig, Similarity(scale, found.rotation, translation))


def _quick_score(target: ScanTarget, sample: Array, vertices: Array, normals: Array) -> float:
    """Mean capped distance (m) both ways, model to scan and (M, 3) scan sample to model."""
    found = match(target, vertices, normals, MatchRules(method="tree", max_distance=CAP, candidates=1))
    there = (found.distances.sum() + CAP * (len(vertices) - len(found.distances))) / len(vertices)
    back, _ = cKDTree(vertices).query(sample, distance_upper_bound=CAP)
    return float(there + np.minimum(back, CAP).mean())


def start_from_frame(rig: Rig, target: ScanTarget, rotation: Array) -> RigParameters:
    """The rest pose in a scan whose axes are known ((3, 3): left, up, front), moved to where it fits best.

    Starts at several heights, because scans are cropped differently, follows each by a few rigid steps of
    iterative closest points, and keeps the best by distances both ways.
    """
    vertex_step = max(1, len(rig.template) // 500)
    chosen = np.arange(0, len(rig.template), vertex_step)
    template, normals = rig.template[chosen], vertex_normals(rig.template, rig.faces)[chosen]
    local = target.vertices @ rotation  # scan in body axes
    sample = target.vertices[:: max(1, len(target.vertices) // 1000)]
    low, high = np.percentile(local, [1, 99], axis=0)
    body_low, body_high = template.min(axis=0), template.max(axis=0)
    middle = np.median(local[:, 0])
    depth = high[2] - body_high[2]
    lowest, highest = high[1] - body_high[1] - 0.25, low[1] - body_low[1] + 0.15
    best: tuple[float, Similarity] | None = None
    for height in np.linspace(min(lowest, highest), max(lowest, highest), 7):
        similarity = Similarity(1.0, rotation, rotation @ np.array([middle, height, depth]))
        for _ in range(8):
            posed = similarity.apply(template)
            rules = MatchRules(method="tree", max_distance=0.08, max_angle=1.2, candidates=1)
            found = match(target, posed, normals @ similarity.rotation.T, rules)
            if len(found.distances) < 20:
                break
            similarity = umeyama(template[found.vertices], found.points)
            similarity = Similarity(float(np.clip(similarity.scale, 0.85, 1.15)), similarity.rotation, np.zeros(3))
            moved = similarity.apply(template[found.vertices])
            similarity = Similarity(
                similarity.scale, similarity.rotation, found.points.mean(axis=0) - moved.mean(axis=0)
            )
        score = _quick_score(target, sample, similarity.apply(template), normals @ similarity.rotation.T)
        if best is None or score < best[0]:
            best = (score, similarity)
    assert best is not None
    return similar_parameters(rig, best[1])
