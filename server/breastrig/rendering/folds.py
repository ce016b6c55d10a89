"""Folds a shade darker and what stands out a shade brighter, so that nipples and folds can be read on a grey scan.

Along an edge from i to j the normal curvature is about (n_j - n_i) (p_j - p_i) / |p_j - p_i|²; its mean over a vertex's
edges, longer ones counting more, is the mean curvature, above zero where the surface is convex.  A depth camera's noise
bends more than a body does, so the means are spread over the surface about as far as a nipple is wide.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from breastrig.core.arrays import Array, Integers
from breastrig.core.srgb import to_srgb
from breastrig.geometry.boundary import directed_edges
from breastrig.geometry.normals import vertex_normals

REACH = 0.0035  # m, standard deviation of the spreading: half a nipple
LEAST_STEPS, MOST_STEPS = 1, 48  # of a mesh with edges of 0.5 mm as well: what is beyond is noise that is seen
SHARPEST = 250.0  # 1/m, a radius of 4 mm: nothing on a body bends more, a spike of the scan does
STRONG = 55.0  # 1/m at which three quarters of the shade are reached: a breast has 17, a nipple 170
FOLD, RIDGE = 0.42, 0.16  # of the brightness, where the surface bends most
FLAT = 1.0 / (1.0 + RIDGE)  # linear light where it does not bend at all: the brightest ridge is white


def bends(vertices: Array, faces: Integers) -> Array:
    """(V,) -1 to 1 of a mesh in metres, outwards: below zero in a fold, above it on a ridge."""
    count = len(vertices)
    start, end = directed_edges(faces).T
    normals = vertex_normals(vertices, faces)
    along = vertices[end] - vertices[start]
    squares = np.einsum("ei,ei->e", along, along)
    turned = np.einsum("ei,ei->e", normals[end] - normals[start], along)
    both = np.concatenate([start, end])
    lengths = np.maximum(np.bincount(both, np.tile(squares, 2), count), 1e-12)
    curvature: Array = np.clip(np.bincount(both, np.tile(turned, 2), count) / lengths, -SHARPEST, SHARPEST)
    # Averaging with the neighbours, half and half, spreads by a quarter of an edge's square in each direction.
    mean_square = max(float(squares.mean()), 1e-12) if len(squares) else 1.0
    steps = int(np.clip(np.round(REACH**2 / (0.25 * mean_square)), LEAST_STEPS, MOST_STEPS))
    around = coo_array((np.ones(len(both)), (both, np.concatenate([end, start]))), shape=(count, count)).tocsr()
    neighbours = np.maximum(around.sum(axis=1), 1.0)
    for _ in range(steps):
        curvature = 0.5 * (curvature + around @ curvature / neighbours)
    return np.tanh(curvature / STRONG)


def shades(vertices: Array, faces: Integers) -> NDArray[np.uint8]:
    """(V, 3) sRGB greys to multiply a plain colour with; FLAT in linear light where the mesh does not bend."""
    bend = bends(vertices, faces)
    light = FLAT * (1.0 + bend * np.where(bend < 0.0, FOLD, RIDGE))
    return np.repeat(np.round(255.0 * to_srgb(light)).astype(np.uint8)[:, None], 3, axis=1)
