"""The rigid motion between two visits, by skin that an operation of the breast leaves alone.

Vertices of the trunk around the breasts that both scans show are laid on each other: along the normal as closely
as scans agree, along the skin loosely, as a fit's vertices slide there.  Tukey's biweight leaves out what moved.  The
error of the motion is a sandwich estimate over patches (Liang and Zeger 1986), because neighbours are wrong together.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadInput
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.report.body_frame import NOT_TRUNK
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig

ROUNDS = 12
TUKEY = 4.685  # times the spread, beyond which a vertex does not count
OF_MAD = 1.4826  # from the median of absolute deviations to a standard deviation
ALONG = 0.010  # m, standard deviation of a vertex along the skin between two fits
LEAST = 0.0005  # m, spread below which nothing is believed
PATCH = 0.06  # m, of skin that is wrong together
NEAR = 0.06  # m from the breasts of the template: farther skin bends and breathes another way (docs/decisions/0042)
FEWEST = 100  # vertices without which nothing is aligned


@dataclass(frozen=True, eq=False)
class Alignment:
    """From the frame of the later scan into that of the earlier one."""

    rotation: Array  # (3, 3)
    translation: Array  # (3,) m
    middle: Array  # (3,) m, about which `covariance` turns
    covariance: Array  # (6, 6) of a turn (rad) and a shift (m)
    spread: float  # m, robust standard deviation along the normal of skin that nobody touched

    def moved(self, points: Array) -> Array:
        """(M, 3) m of the later scan, in the earlier one's frame."""
        return np.asarray(points @ self.rotation.T + self.translation)

    def slopes(self, points: Array, directions: Array) -> Array:
        """(M, 6): how the (M, 3) points move along (M, 3) unit directions with the motion's six numbers."""
        return np.concatenate([np.cross(points - self.middle, directions), directions], axis=1)


@lru_cache(maxsize=8)
def untouched(rig: Rig) -> Booleans:
    """(V,) the trunk's vertices around the breasts, read-only."""
    trunk, breasts = np.ones(len(rig.template), dtype=np.bool_), np.zeros(len(rig.template), dtype=np.bool_)
    for name, members in rig.regions.items():
        trunk[members] &= not name.startswith((*NOT_TRUNK, "neck"))
        breasts[members] |= name.startswith("breast")
    found = trunk & (cKDTree(rig.template[breasts]).query(rig.template)[0] < NEAR)
    found.flags.writeable = False
    return found


def aligned(earlier: Stance, later: Stance) -> Alignment:
    """Raises BadInput where the two scans share too little skin beside the breasts."""
    used = untouched(earlier.rig) & np.isfinite(earlier.distances) & np.isfinite(later.distances)
    if int(used.sum()) < FEWEST:
        raise BadInput("The two scans share too little skin beside the breasts to be laid on each other.")
    normals = vertex_normals(earlier.vertices, earlier.rig.faces)
    return laid(earlier.vertices[used], normals[used], later.vertices[used], later.search)


def laid(points: Array, normals: Array, theirs: Array, later: ClosestPointSearch) -> Alignment:
    """The motion that lays the later skin on (N, 3) m points with (N, 3) normals, of which it has `theirs` (N, 3) m."""
    middle = points.mean(axis=0)
    rotation = Rotation.align_vectors(points - middle, theirs - theirs.mean(axis=0))[0].as_matrix()
    translation = middle - rotation @ theirs.mean(axis=0)
    tangents = np.linalg.svd(normals[:, None])[2][:, 1:]  # (N, 2, 3)
    for _ in range(ROUNDS):
        here = later.query((points - translation) @ rotation).points @ rotation.T + translation
        off = np.einsum("ni,ni->n", here - points, normals)
        spread = max(OF_MAD * float(np.median(np.abs(off - np.median(off)))), LEAST)
        weight = np.maximum(1.0 - (off / (TUKEY * spread)) ** 2, 0.0) ** 2
        rows = np.concatenate([np.cross(points - middle, normals), normals], axis=1) / spread
        slid = np.einsum("nki,ni->nk", tangents, theirs @ rotation.T + translation - points) / ALONG
        sideways = np.concatenate([np.cross((points - middle)[:, None], tangents), tangents], axis=2) / ALONG
        pulls = rows * (off / spread)[:, None] + np.einsum("nkj,nk->nj", sideways, slid)
        each = weight[:, None] * pulls
        normal = (weight[:, None] * rows).T @ rows + np.einsum("n,nkj,nkl->jl", weight, sideways, sideways)
        step = -np.linalg.solve(normal, each.sum(axis=0))
        turn = Rotation.from_rotvec(step[:3]).as_matrix()
        rotation, translation = turn @ rotation, turn @ (translation - middle) + middle + step[3:]
        if np.abs(step).max() < 1e-6:
            break
    _, patch = np.unique(np.floor(points / PATCH).astype(np.int64), axis=0, return_inverse=True)
    sums = np.stack([np.bincount(patch.ravel(), column) for column in each.T], axis=1)
    inverse, count = np.linalg.inv(normal), len(sums)
    covariance = inverse @ (sums.T @ sums) @ inverse * count / max(count - 6, 1)
    return Alignment(rotation, translation, middle, covariance, spread)
