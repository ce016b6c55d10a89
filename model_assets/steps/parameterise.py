"""Texture coordinates without seams: the torso pressed flat like a paper doily.

The waist lies on a circle, neck and arms are closed with one extra vertex each; with positive weights and a
convex border no triangle folds over (Tutte 1963, Floater 2003).  The extra vertices are then forgotten.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from steps.remesh import border_edges
from steps.source import Array, Integers


def border_loops(triangles: Integers) -> list[Integers]:
    """Each border as its vertices in order, the longest loop in space of names unknown; sorted by first vertex."""
    after = {int(a): int(b) for a, b in border_edges(triangles)}
    loops = []
    while after:
        start = min(after)
        loop = [start]
        while (following := after.pop(loop[-1])) != start:
            loop.append(following)
        loops.append(np.array(loop))
    return loops


def flattened(vertices: Array, triangles: Integers) -> Array:
    """(V, 2) in the unit square; the lowest border lies on the circle, the front's middle at the bottom."""
    loops = sorted(border_loops(triangles), key=lambda loop: float(vertices[loop, 1].mean()))
    rim, holes = loops[0], loops[1:]
    count = len(vertices)
    extended, extra = [triangles], []
    for number, loop in enumerate(holes):
        centre = np.full(len(loop), count + number)
        extended.append(np.stack([np.roll(loop, -1), loop, centre], axis=1))
        extra.append(vertices[loop].mean(axis=0))
    t = np.concatenate(extended)
    points = np.concatenate([vertices, np.array(extra).reshape(-1, 3)])
    total = len(points)
    # Floater's mean value weights: positive and kinder to shapes than uniform ones
    rows, columns, values = [], [], []
    for i in range(3):
        a, b, c = t[:, i], t[:, (i + 1) % 3], t[:, (i + 2) % 3]
        u, w = points[b] - points[a], points[c] - points[a]
        lu, lw = np.linalg.norm(u, axis=1), np.linalg.norm(w, axis=1)
        half = np.tan(0.5 * np.arccos(np.clip((u * w).sum(1) / (lu * lw), -1.0, 1.0)))
        rows += [a, a]
        columns += [b, c]
        values += [half / lu, half / lw]
    weights = sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (total, total)
    )
    weights = sparse.diags(1.0 / np.asarray(weights.sum(axis=1)).ravel()) @ weights
    step = np.linalg.norm(vertices[np.roll(rim, -1)] - vertices[rim], axis=1)
    along = np.concatenate([[0.0], np.cumsum(step)[:-1]]) / step.sum()
    front = int(np.argmax(np.where(np.abs(vertices[rim, 0]) < 1e-9, vertices[rim, 2], -np.inf)))
    angle = 2 * np.pi * (along - along[front]) - 0.5 * np.pi
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    free = np.setdiff1d(np.arange(total), rim)
    system = (sparse.identity(total, format="csr") - weights)[free]
    result = np.zeros((total, 2))
    result[rim] = circle
    result[free] = spsolve(system[:, free].tocsc(), -(system[:, rim] @ circle))
    return np.asarray(0.5 + 0.49 * result[:count])
