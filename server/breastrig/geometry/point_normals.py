"""Normals of a cloud of points: the flattest direction of each neighbourhood, all on one side of the surface.

A neighbourhood says the direction but not the side.  The sides are carried from point to point along the tree of
neighbours that are most nearly parallel (Hoppe and others, "Surface reconstruction from unorganized points", 1992); for
each connected part one side is then chosen: that of the sensor where it is known, else away from the part's middle.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers

NEIGHBOURS = 12  # of a plane: fewer are noise, more bend with the skin
LINKED = 8  # of these the sides are carried along
LEAST_WEIGHT = 1e-4  # of a link between parallel points: zero would be no link at all
CLEARLY = 0.2  # mean cosine to the sensor below which it saw both sides, as of a body that was scanned all around


def point_normals(points: Array, sensor: Array | None = None) -> Array:
    """(N, 3) unit normals of (N, 3) m points; `sensor` (3,) m is the place that they were seen from."""
    near = np.asarray(cKDTree(points).query(points, k=min(NEIGHBOURS, len(points)))[1])
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]
    return on_one_side(points, normals, near[:, 1 : LINKED + 1], sensor)


def on_one_side(points: Array, normals: Array, near: Integers, sensor: Array | None) -> Array:
    """The (N, 3) normals, turned: (N, K) are the neighbours of each point."""
    count = len(points)
    rows, columns = np.repeat(np.arange(count), near.shape[1]), near.ravel()
    weights = LEAST_WEIGHT + 1.0 - np.abs(np.einsum("ni,ni->n", normals[rows], normals[columns]))
    links = coo_array((weights, (rows, columns)), (count, count)).tocsr()
    tree = minimum_spanning_tree(links.maximum(links.T))
    parts, part = connected_components(tree, directed=False)
    signs = np.ones(count)
    for root in np.unique(part, return_index=True)[1]:
        order, parents = breadth_first_order(tree, root, directed=False)
        agrees = np.einsum("ni,ni->n", normals[order[1:]], normals[parents[order[1:]]]) >= 0.0
        for place, parent, same in zip(order[1:].tolist(), parents[order[1:]].tolist(), agrees.tolist(), strict=True):
            signs[place] = signs[parent] if same else -signs[parent]
    turned = normals * signs[:, None]
    members = np.maximum(np.bincount(part, minlength=parts), 1)
    middle = np.stack([np.bincount(part, points[:, axis], parts) for axis in range(3)], axis=1) / members[:, None]
    outwards = np.bincount(part, np.einsum("ni,ni->n", turned, points - middle[part]), parts)
    if sensor is not None:
        arms = sensor - points
        arms /= np.maximum(np.linalg.norm(arms, axis=1, keepdims=True), 1e-12)
        facing = np.bincount(part, np.einsum("ni,ni->n", turned, arms), parts) / members
        outwards = np.where(np.abs(facing) > CLEARLY, facing, outwards)
    return np.asarray(turned * np.where(outwards < 0.0, -1.0, 1.0)[part][:, None])
