"""A breast taken off: its region becomes the smooth surface that continues the chest wall around it.

Coordinates are filled so that Δ²x = τ Δx on the mesh's graph (bending with a little tension): the fill leaves the
border in the direction of the skin there and does not bulge as pure bending does nor crease as a soap film.
Each stance is filled for itself over the same vertices, so that they still correspond.
"""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import spsolve

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.half_edges import neighbours

TENSION = 0.02  # of the graph's Laplacian; 0 is pure bending
MEDIAL = 0.014  # m that stay beside the midline
LATERAL = 0.078  # m outwards of the nipple
ABOVE, BELOW = 0.115, 0.030  # m above the nipple and below the fold
ALONG = 0.19  # m along the skin from the nipple at most, so that the arm stays
FRONT = -0.01  # m; behind it the back begins


def breast_region(vertices: Array, faces: Integers, nipple: Array, fold: Array, middle: float) -> Booleans:
    """(V,) the vertices of a standing body's breast; `middle` is the x of the midline (m)."""
    side = np.sign(nipple[0] - middle)
    out = side * (vertices[:, 0] - middle)
    inner, outer = MEDIAL, side * (nipple[0] - middle) + LATERAL
    low, high = min(fold[1], nipple[1] - 0.02) - BELOW, nipple[1] + ABOVE
    across = (out - 0.5 * (inner + outer)) / (0.5 * (outer - inner))
    along = (vertices[:, 1] - 0.5 * (low + high)) / (0.5 * (high - low))
    inside = (across**2 + along**2 < 1.0) & (vertices[:, 2] > FRONT)
    i, j = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    ways = coo_array((np.linalg.norm(vertices[i] - vertices[j], axis=1), (i, j)), shape=2 * (len(vertices),)).tocsr()
    start = int(np.linalg.norm(vertices - nipple, axis=1).argmin())
    inside &= dijkstra(ways, directed=False, indices=[start], limit=ALONG)[0] < np.inf
    kept = inside[i] & inside[j]
    links = coo_array((np.ones(int(kept.sum())), (i[kept], j[kept])), shape=2 * (len(vertices),))
    _, piece = connected_components(links, directed=False)
    return np.asarray(inside & (piece == piece[start]))


def filled(vertices: Array, faces: Integers, region: Booleans) -> Array:
    """(V, 3) m with the region as the smooth continuation of what is around it."""
    links = neighbours(faces, len(vertices))
    links.data[:] = 1.0
    degree = np.maximum(links.sum(axis=1), 1.0)
    laplacian = csr_array(diags_array(degree) - links)
    energy = csr_array(laplacian @ diags_array(1.0 / degree) @ laplacian + TENSION * laplacian)
    inner = np.flatnonzero(region)
    outer = np.flatnonzero(~region)
    rows = energy[inner]
    result = vertices.copy()
    result[inner] = spsolve(rows[:, inner].tocsc(), -(rows[:, outer] @ vertices[outer]))
    return result
