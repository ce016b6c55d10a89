"""Similarities: the best one between two sets of points, and the rest pose carried by one.

Umeyama, Least-squares estimation of transformation parameters between two point patterns, 1991.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadLandmarks
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


def similar_parameters(rig: Rig, similarity: Similarity) -> RigParameters:
    """The rest pose carried by a similarity: its scale goes into every bone."""
    rest = rest_parameters(rig)
    return RigParameters(
        rotations=similarity.rotation @ rest.rotations,
        translations=similarity.apply(rest.translations),
        scales=np.full_like(rest.scales, similarity.scale),
        weights=rest.weights,
    )
