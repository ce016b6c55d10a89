"""A smooth free-form layer over the parametric fit, for what 55 shapes cannot show.

Every vertex may move along its own normal only, by h_i, so nothing slides along the skin.  h solves

    Σ_matched w_i (n_i·q_i (h_i + g_i) / σ)²  +  hᵀ (K M⁻¹ K) h / b²  +  hᵀ M h / s²        (linear, sparse, SPD)

with the gap g_i to the matched scan point along the model normal n_i (q_i: the scan's normal there), the cotangent
stiffness K and the lumped areas M of the fitted surface (Botsch and Sorkine, On linear variational surface
deformation methods, 2008): bending keeps it smooth, the last term lets it die out where the scan shows nothing.
Matches are renewed a few times; where a triangle would turn over,
bending is stiffened until it does not.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from breastrig.core.arrays import Array, Integers
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import face_normals, vertex_normals

ROUNDS = 2  # renewals of the matches; a third gains nothing
RULES = MatchRules(method="rays", max_distance=0.015, max_angle=0.87)  # as the fit's last stage
SIGMA = 0.0010  # m, noise of the scan where a vertex meets it
BENDING = 0.7  # 1/m, expected root of the summed squared curvature change: folds and muscles, not noise
DYING = 0.004  # m·m, expected root of the summed squared displacement on the scan's skin
FADE = 0.004  # m from the scan, over which the layer dies out: what is not seen stays as the model has it
STIFFER = 100.0  # by which bending is strengthened around a turned triangle, at most STIFFENINGS times
STIFFENINGS = 5


@dataclass(frozen=True, eq=False)
class Refined:
    """The refined surface."""

    vertices: Array  # (V, 3) m
    displacement: Array  # (V,) m along the fitted model's normals


def stiffness_and_area(vertices: Array, faces: Integers) -> tuple[sp.csc_array, Array]:
    """((V, V) cotangent stiffness, (V,) m² a third of the area around each vertex)."""
    count = len(vertices)
    rows, columns, values = [], [], []
    area = np.zeros(count)
    corners = vertices[faces]
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    for k in range(3):
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        cotangent = 0.5 * np.einsum("fi,fi->f", a, b) / np.maximum(double, 1e-12)
        cotangent = np.maximum(cotangent, 1e-3)  # obtuse corners must not make it indefinite
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-cotangent, -cotangent, cotangent, cotangent]
        area += np.bincount(faces[:, k], weights=double / 6.0, minlength=count)
    index = (np.concatenate(rows), np.concatenate(columns))
    return sp.csc_array(sp.coo_array((np.concatenate(values), index), shape=(count, count))), area


def _turned(before: Array, vertices: Array, faces: Integers) -> Integers:
    """Vertices of triangles that turned over."""
    return np.unique(faces[np.einsum("fi,fi->f", before, face_normals(vertices, faces)) <= 0.0])


def refined(target: ScanTarget, vertices: Array, faces: Integers) -> Refined:
    """(V, 3) m fitted vertices, moved along their normals onto the scan where it shows skin."""
    normals, facing = vertex_normals(vertices, faces), face_normals(vertices, faces)
    stiffness, area = stiffness_and_area(vertices, faces)
    bending = 1.0 / (area * BENDING**2)
    away = target.vertex_tree.query(vertices)[0]
    dying = sp.diags_array(area / DYING**2 * (1.0 + (away / FADE) ** 4))
    heights = np.zeros(len(vertices))
    for _ in range(ROUNDS):
        moved = vertices + heights[:, None] * normals
        found = match(target, moved, vertex_normals(moved, faces), RULES)
        q = np.einsum("mi,mi->m", found.normals, normals[found.vertices])
        gap = np.einsum("mi,mi->m", found.normals, vertices[found.vertices] - found.points)
        weight = np.zeros(len(vertices))
        weight[found.vertices] = area[found.vertices] / area.mean() * (q / SIGMA) ** 2
        right = np.zeros(len(vertices))
        right[found.vertices] = -area[found.vertices] / area.mean() * q * gap / SIGMA**2
        for _ in range(STIFFENINGS + 1):
            system = sp.csc_array(sp.diags_array(weight) + dying + stiffness @ sp.diags_array(bending) @ stiffness)
            candidate = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
            turned = _turned(facing, vertices + candidate[:, None] * normals, faces)
            if not len(turned):
                heights = candidate
                break
            around = np.unique(faces[np.isin(faces, turned).any(axis=1)])
            bending[around] *= STIFFER
    return Refined(vertices + heights[:, None] * normals, heights)
