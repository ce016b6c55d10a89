"""Similarities: the best one between two sets of points, or many at once, and the rest pose carried by one.

The tries of rigid_search.py go through their few steps together: one by one the calls would cost more than the work.

Umeyama, Least-squares estimation of transformation parameters between two point patterns, 1991.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadLandmarks
from breastrig.core.stances import OUTWARDS, split_side
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters


@dataclass(frozen=True, eq=False)
class Similarity:
    """x -> scale * rotation @ x + translation"""

    scale: float
    rotation: Array  # (3, 3)
    translation: Array  # (3,) m

    def apply(self, points: Array) -> Array:
        """(M, 3) -> (M, 3)"""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)


@dataclass(frozen=True, eq=False)
class Similarities:
    """T times x -> scale * rotation @ x + translation"""

    scales: Array  # (T,)
    rotations: Array  # (T, 3, 3)
    translations: Array  # (T, 3) m

    @classmethod
    def of(cls, each: Sequence[Similarity]) -> "Similarities":
        return cls(
            np.array([one.scale for one in each]),
            np.array([one.rotation for one in each]),
            np.array([one.translation for one in each]),
        )

    def one(self, number: int) -> Similarity:
        return Similarity(float(self.scales[number]), self.rotations[number], self.translations[number])

    def chosen(self, numbers: Integers) -> "Similarities":
        return Similarities(self.scales[numbers], self.rotations[numbers], self.translations[numbers])

    def where(self, stays: Booleans, other: "Similarities") -> "Similarities":
        """These similarities where `stays` (T,), else the other ones."""
        return Similarities(
            np.where(stays, self.scales, other.scales),
            np.where(stays[:, None, None], self.rotations, other.rotations),
            np.where(stays[:, None], self.translations, other.translations),
        )

    def apply(self, points: Array) -> Array:
        """(M, 3) -> (T, M, 3)"""
        turned = points @ self.rotations.transpose(0, 2, 1)
        return np.asarray(self.scales[:, None, None] * turned + self.translations[:, None])

    def undone(self, points: Array) -> Array:
        """The inverse map: (M, 3) -> (T, M, 3)."""
        return np.asarray((points - self.translations[:, None]) @ self.rotations / self.scales[:, None, None])


def umeyama(source: Array, target: Array, weights: Array | None = None) -> Similarity:
    """The similarity (no reflection) that carries (M, 3) source points to target points best; M >= 3.

    weights (M,) >= 0 default to one each.
    """
    share = np.ones(len(source)) if weights is None else weights
    share = share / share.sum()
    mean_s, mean_t = share @ source, share @ target
    centred_s, centred_t = source - mean_s, target - mean_t
    u, d, vt = np.linalg.svd((centred_t * share[:, None]).T @ centred_s)
    if d[1] < 1e-6 * max(d[0], 1e-30):
        raise BadLandmarks("The landmarks lie on one line; pick at least three that do not.")
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = (u * signs) @ vt
    scale = float((d * signs).sum() / (share @ (centred_s**2).sum(axis=1)))
    return Similarity(scale, rotation, mean_t - scale * rotation @ mean_s)


def nearest_similarities(
    source: Array, targets: Array, weights: Array | Booleans, scales: tuple[float, float] = (0.0, np.inf)
) -> Similarities:
    """The similarities that carry (M, 3) or (T, M, 3) source points to (T, M, 3) target points best.

    `umeyama`, T times, with (T, M) weights >= 0 and the scale kept within bounds.  A try with fewer than three pairs
    of any weight, or with pairs on one line, gives some similarity that means nothing.
    """
    each = np.broadcast_to(source, targets.shape)
    share = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
    mean_s, mean_t = (share[:, None] @ each)[:, 0], (share[:, None] @ targets)[:, 0]
    crossed = (targets * share[:, :, None]).transpose(0, 2, 1) @ each - mean_t[:, :, None] * mean_s[:, None, :]
    spread = np.einsum("tm,tmi,tmi->t", share, each, each) - (mean_s**2).sum(axis=1)
    u, d, vt = np.linalg.svd(crossed)
    signs = np.ones_like(d)
    signs[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotations = (u * signs[:, None, :]) @ vt
    found = np.clip((d * signs).sum(axis=1) / np.maximum(spread, 1e-12), *scales)
    return Similarities(found, rotations, mean_t - found[:, None] * np.einsum("tij,tj->ti", rotations, mean_s))


def similar_parameters(rig: Rig, similarity: Similarity) -> RigParameters:
    """The rest pose carried by a similarity: its scale goes into every bone."""
    rest = rest_parameters(rig)
    return RigParameters(
        rotations=similarity.rotation @ rest.rotations,
        translations=similarity.apply(rest.translations),
        scales=np.full_like(rest.scales, similarity.scale),
        weights=rest.weights,
    )


def body_axes(rig: Rig, vertices: Array) -> Array:
    """(3, 3) columns: the body's left, up and front in the frame of its (V, 3) m vertices."""
    points = rig.landmark_points()
    try:
        return umeyama(points.positions(rig.template, rig.faces), points.positions(vertices, rig.faces)).rotation
    except BadLandmarks:  # a rig may have too few, or all on one line
        return umeyama(rig.template, vertices).rotation


def outwards(name: str) -> Array:
    """(3,) signs that turn a left landmark's shift, in the body's axes, into this landmark's."""
    return np.array([OUTWARDS.get(split_side(name)[1], 1.0), 1.0, 1.0])
