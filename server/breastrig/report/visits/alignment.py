"""The rigid motion between two visits, by skin that an operation of the breast leaves alone.

Vertices of the trunk around the breasts that both scans show are laid on each other: along the normal as closely
as scans agree, along the skin loosely, as a fit's vertices slide there.  Tukey's biweight leaves out what moved.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.report.body_frame import trunk
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig

ROUNDS = 12
TUKEY = 4.685  # times the spread, beyond which a vertex does not count
OF_MAD = 1.4826  # from the median of absolute deviations to a standard deviation
ALONG = 0.010  # m, standard deviation of a vertex along the skin between two fits
LEAST = 0.0005  # m, spread below which nothing is believed
NEAR = 0.06  # m from the breasts of the template: farther skin bends and breathes another way (docs/decisions/0042)
FEWEST = 100  # vertices without which nothing is aligned


@dataclass(frozen=True, eq=False)
class Alignment:
    """From the frame of the later scan into that of the earlier one."""

    rotation: Array  # (3, 3)
    translation: Array  # (3,) m
    spread: float  # m, robust standard deviation along the normal of skin that nobody touched

    def moved(self, points: Array) -> Array:
        """(M, 3) m of the later scan, in the earlier one's frame."""
        return np.asarray(points @ self.rotation.T + self.translation)


@lru_cache(maxsize=8)
def on_breasts(rig: Rig) -> Integers:
    """The vertices of the regions of the breasts."""
    members = [each for name, each in rig.regions.items() if name.startswith("breast")]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *members]))


@lru_cache(maxsize=8)
def untouched(rig: Rig) -> Integers:
    """The trunk's vertices around the breasts."""
    beside = trunk(rig)
    return beside[cKDTree(rig.template[on_breasts(rig)]).query(rig.template[beside])[0] < NEAR]


def aligned(earlier: Stance, later: Stance) -> Alignment:
    """Raises BadInput where the two scans share too little skin beside the breasts."""
    used = untouched(earlier.rig)
    used = used[np.isfinite(earlier.distances[used]) & np.isfinite(later.distances[used])]
    if len(used) < FEWEST:
        raise BadInput("The two scans share too little skin beside the breasts to be laid on each other.")
    normals = vertex_normals(earlier.vertices, earlier.rig.faces)
    return laid(earlier.vertices[used], normals[used], later.vertices[used], later.search)


def laid(points: Array, normals: Array, theirs: Array, later: ClosestPointSearch) -> Alignment:
    """The motion that lays the later skin on (N, 3) m points with (N, 3) normals, of which it has `theirs` (N, 3) m."""
    middle = points.mean(axis=0)
    rotation = Rotation.align_vectors(points - middle, theirs - theirs.mean(axis=0))[0].as_matrix()
    translation = middle - rotation @ theirs.mean(axis=0)
    ways = np.linalg.svd(normals[:, None])[2]  # (N, 3, 3): the normal, and two along the skin
    ways[:, 0] = normals
    slopes = np.concatenate([np.cross((points - middle)[:, None], ways), ways], axis=2)  # (N, 3, 6)
    for _ in range(ROUNDS):
        skin = later.query((points - translation) @ rotation).points @ rotation.T + translation
        there = theirs @ rotation.T + translation
        off = np.einsum("nki,nki->nk", np.stack([skin, there, there], axis=1) - points[:, None], ways)
        spread = max(OF_MAD * float(np.median(np.abs(off[:, 0] - np.median(off[:, 0])))), LEAST)
        weight = np.maximum(1.0 - (off[:, 0] / (TUKEY * spread)) ** 2, 0.0) ** 2
        width = np.array([spread, ALONG, ALONG])
        rows = slopes / width[:, None]
        normal = np.einsum("n,nkj,nkl->jl", weight, rows, rows)
        step = -np.linalg.solve(normal, np.einsum("n,nkj,nk->j", weight, rows, off / width))
        turn = Rotation.from_rotvec(step[:3]).as_matrix()
        rotation, translation = turn @ rotation, turn @ (translation - middle) + middle + step[3:]
        if np.abs(step).max() < 1e-6:
            break
    return Alignment(rotation, translation, spread)
