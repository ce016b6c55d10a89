"""Transfers a change of the standing skin to the lying skin of the same patient.

Per vertex, the rotation between the stances is the best one of its edges (Kabsch), smoothed over the skin. Each edge's
change is turned by the rotation of its ends and added to the lying edge; positions follow by least squares (as
deformation transfer does, Sumner and Popović 2004). Edges, not positions, because arms that lie aside must stay on
their shoulders when the trunk becomes longer. Where the back lies on the table it stays on it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.half_edges import neighbours

ROUNDS = 30  # of averaging the rotations over neighbours: some 50 mm
HELD = 1e-5  # of the trunk to the standing change; only settles where all of it is
LIFTED = 0.06  # m over the table, from where the skin moves freely


@dataclass(frozen=True, eq=False)
class Carrier:
    """Transfers changes between one pair of corresponding skins."""

    edges: Integers  # (E, 2)
    rotations: Array  # (E, 3, 3) from standing to lying


def carrier(standing: Array, lying: Array, faces: Integers) -> Carrier:
    """Between two skins (V, 3) m on the same (F, 3) triangles."""
    i, j = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    edges = np.unique(np.sort(np.stack([i, j], axis=1), axis=1), axis=0)
    before, after = (each[edges[:, 1]] - each[edges[:, 0]] for each in (standing, lying))
    products = np.einsum("ei,ej->eij", after, before) / np.maximum((before**2).sum(axis=1), 1e-12)[:, None, None]
    ends = coo_array(
        (np.ones(2 * len(edges)), (edges.T.ravel(), np.tile(np.arange(len(edges)), 2))),
        shape=(len(standing), len(edges)),
    ).tocsr()
    turned = _nearest_rotations((ends @ products.reshape(-1, 9)).reshape(-1, 3, 3))
    mean = csr_array(0.5 * (diags_array(np.ones(len(standing))) + neighbours(faces, len(standing))))
    flat = turned.reshape(-1, 9)
    for _ in range(ROUNDS):
        flat = mean @ flat
    smooth = _nearest_rotations(flat.reshape(-1, 3, 3))
    return Carrier(edges, _nearest_rotations(smooth[edges[:, 0]] + smooth[edges[:, 1]]))


def carried(standing: Array, changed: Array, lying: Array, table: float, by: Carrier) -> Array:
    """(V, 3) m: the lying skin with the standing one's change; it touches the table where it did."""
    first, second = by.edges.T
    shift = changed - standing
    wanted = np.einsum("eij,ej->ei", by.rotations, shift[second] - shift[first])
    count, rows = len(standing), np.arange(len(first))
    ends = coo_array(
        (
            np.concatenate([-np.ones(len(rows)), np.ones(len(rows))]),
            (np.tile(rows, 2), np.concatenate([first, second])),
        ),
        shape=(len(rows), count),
    ).tocsr()
    hold = HELD * (np.abs(standing[:, 0]) < 0.12)
    solver = splu((ends.T @ ends + diags_array(hold)).tocsc())
    moved = lying + solver.solve(np.ascontiguousarray(ends.T @ wanted + hold[:, None] * shift))
    free = np.clip((lying[:, 2] - table) / LIFTED, 0.0, 1.0)
    free = free * free * (3.0 - 2.0 * free)
    moved[:, 2] = lying[:, 2] + free * (moved[:, 2] - lying[:, 2])
    on_top = lying[:, 2] >= table  # what lies deeper than the table (arms beside it) may stay there
    moved[on_top, 2] = np.maximum(moved[on_top, 2], table)
    return np.asarray(moved)


def _nearest_rotations(matrices: Array) -> Array:
    """(…, 3, 3) the rotation nearest to each."""
    left, _, right = np.linalg.svd(matrices)
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[..., None]
    return np.asarray(left @ right)
