"""Nipples on the skin of an MR image: bumps near the foremost places of both sides, left and right by the frame (LPS).

A place stands out by how far it lies above the mean of the skin around, less what a sphere of the same wider curvature
does; breasts are spheres of 40 mm and more, nipples bumps of 10.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import vertex_normals

FINE, COARSE = 9.0, 24.0  # mm, radii of the skin around
FOREMOST = 50.0  # mm behind the foremost place of a side, within which its nipple lies
BESIDE = 15.0  # mm from the middle
CLEAR = 0.4  # mm that a nipple stands out at least
ALONE, APART = 0.7, 15.0  # share of that which anything farther away (mm) may have: which of two is it?
BUMP, SHARE = 12.0, 0.5  # mm around the most outstanding place, and share of it: what belongs to the bump
RADIUS = 6.0  # mm, 90 % of the nipples found lie within, on bodies that are none of the rig's too


@dataclass(frozen=True, eq=False)
class SeenNipple:
    """A nipple seen in the image."""

    side: Literal["L", "R"]
    place: Array  # (3,) mm, LPS
    radius_mm: float  # that holds the true place with 90 %


def nipples_on(vertices: Array, faces: Integers, middle: float) -> tuple[SeenNipple, ...]:
    """Of (V, 3) mm vertices and (F, 3) faces in LPS, the body's middle at x = `middle`; none where no bump is alone."""
    normals, tree = vertex_normals(vertices, faces), cKDTree(vertices)
    sides: tuple[tuple[Literal["L", "R"], float], ...] = (("L", 1.0), ("R", -1.0))
    found = []
    for side, outwards in sides:
        half = np.flatnonzero(outwards * (vertices[:, 0] - middle) > BESIDE)
        if not len(half):
            continue
        near = half[vertices[half, 1] < vertices[half, 1].min() + FOREMOST]
        places = vertices[near]
        fine, coarse = (
            np.einsum("vc,vc->v", places - _means(tree, vertices, places, radius), normals[near])
            for radius in (FINE, COARSE)
        )
        bump = fine - (FINE / COARSE) ** 2 * coarse
        top = int(bump.argmax())
        away = np.linalg.norm(places - places[top], axis=1)
        if bump[top] < CLEAR or bump[away > APART].max(initial=0.0) > ALONE * bump[top]:
            continue
        weights = np.where(away < BUMP, np.maximum(bump - SHARE * bump[top], 0.0), 0.0)
        found.append(SeenNipple(side, weights @ places / weights.sum(), RADIUS))
    return tuple(found)


def _means(tree: cKDTree, vertices: Array, places: Array, radius: float) -> Array:
    """(N, 3) the mean of the vertices around each place."""
    near = cKDTree(places).sparse_distance_matrix(tree, radius, output_type="ndarray")
    number, around = near["i"], vertices[near["j"]]  # of a place, itself among those around it
    sums = np.stack([np.bincount(number, axis, len(places)) for axis in around.T], axis=1)
    return np.asarray(sums / np.bincount(number, minlength=len(places))[:, None])
