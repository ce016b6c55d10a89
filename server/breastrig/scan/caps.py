"""Detects flat pieces with which programs close a scan: a plate behind it, lids on neck, waist and arms.

None of them is skin. A lid is planar to a fraction of a millimetre, as no scanned surface is. The surface beside it
lies behind it and meets it at an edge; a table or a floor has the body in front of it. A triangle fan over a ragged
border folds over itself, so it contains both windings. Evidence: docs/decisions/0022.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, all_in_row, any_in_row, lengths
from breastrig.geometry.normals import unit_vectors

TURN_BIN, HEIGHT_BIN = 0.02, 0.001  # of a normal's coordinates, and m: triangles of one plane share a bin
FAR = 2**14  # bins
LEAST_BIN = 2e-4  # m², of a bin that is looked at
PLANAR = 3e-4  # m to either side; files round to a tenth of a millimetre, scanned tables have 0.6 mm and more
ALIKE = np.cos(np.radians(3.0))
LEAST = 2.5e-3  # m², smaller than the cut through an upper arm; a tenth of that is one triangle of a coarse mesh
EDGE = np.cos(np.radians(30.0))  # to what adjoins it; facets of a body of 200 triangles turn by less
BEHIND = 0.9  # share of what adjoins it that lies behind it
MOST = 12  # planes that are looked at, the largest first


def caps(vertices: Array, faces: Integers, crosses: Array) -> Booleans:
    """(F,) which triangles, outwards and with these (F, 3) face_crosses, are lids of a scan with (V, 3) m vertices."""
    normals, areas = unit_vectors(crosses), 0.5 * lengths(crosses)
    heights = np.einsum("fi,fi->f", normals, vertices[faces[:, 0]] - vertices[0])
    bins = np.round(np.column_stack([normals / TURN_BIN, np.clip(heights / HEIGHT_BIN, -FAR, FAR)])).astype(np.int64)
    _, member = np.unique((bins + FAR) @ (2 * FAR) ** np.arange(4), return_inverse=True)
    sizes = np.bincount(member, areas)
    result = np.zeros(len(faces), dtype=np.bool_)
    for which in np.argsort(-sizes)[:MOST]:
        seed = (member == which) & ~result
        if sizes[which] < LEAST_BIN or not seed.any():
            continue
        normal = unit_vectors(crosses[seed].sum(axis=0, keepdims=True))[0]
        level = float(np.average(heights[seed], weights=areas[seed]))
        away = (vertices - vertices[0]) @ normal - level
        near: Booleans = (all_in_row(np.abs(away)[faces] < PLANAR)) & (np.abs(normals @ normal) > ALIKE)
        if areas[near].sum() >= LEAST and _closes(faces, near, away, normals @ normal):
            result |= near
    return result


def _closes(faces: Integers, near: Booleans, away: Array, along: Array) -> bool:
    """Whether what adjoins these triangles, all else where nothing does, lies behind them, beyond an edge."""
    theirs = np.zeros(len(away), dtype=np.bool_)
    theirs[faces[near]] = True
    beside: Booleans = any_in_row(theirs[faces]) & ~near
    if beside.any():
        return bool((away[faces[beside]].mean(axis=1) < 0.0).mean() > BEHIND and np.median(along[beside]) < EDGE)
    if near.all():
        return False
    return bool((away[faces[~near]].mean(axis=1) < 0.0).mean() > BEHIND)
