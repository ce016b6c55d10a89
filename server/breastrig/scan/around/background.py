"""Cuts floors and walls around a patient away, before any other analysis.

A scan of a room contains large planes, and so does the scan of a supine patient on a table. The body tells them apart:
on a table it begins close above the plane and is not high; before a wall or on a floor it is away from the plane, or
high above it. So each large plane is judged by the body that is left without it.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import triangle_components
from breastrig.scan.around.table import Table, found_table
from breastrig.scan.clean import FRAGMENT_SHARE, MIN_TRIANGLES, large_pieces
from breastrig.scan.orient import Frame, propose_frame

PLANES = 6  # at most: a floor, four walls and a table top
HIGH = 0.45  # m above a plane that the body reaches: lying torsos of the given patients reach 0.29
AWAY = 0.20  # m from a plane to where the body begins: 0.10 there, where arms and flanks come down to the table
REACHES = (0.02, 0.98)  # quantiles of the body's heights: what curls up at the edge of a plane does not count
FLAT = 0.02  # m, standard deviation across a piece that is another plane and no body

Planes = tuple[tuple[Array, float], ...]  # (3,) unit normal to the body, and height along it (m)


@dataclass(frozen=True, eq=False)
class WithoutBackground:
    """A scan without its floors and walls."""

    faces: Integers  # (F, 3) of the same vertices
    frame: Frame  # as seen on what is left, with the planes that were cut
    table: Table | None = None  # what was found for frame.table on the way


def without_background(vertices: Array, faces: Integers, stands: bool = False) -> WithoutBackground:
    """The triangles that are no floor or wall; all of them where there is none.

    `stands`: it is known that no plane is a table, however close the body is to it.
    """
    planes: Planes = ()
    frame = propose_frame(vertices, faces)
    table: Table | None = None
    while frame.table is not None and len(planes) < PLANES:
        table = found_table(vertices, faces, *frame.table)
        if not stands and _all_is_low(vertices[faces[~table.triangles, 0]] @ frame.table[0] - frame.table[1]):
            break  # as above any table, and what is left need not be taken apart
        kept = _left_by(table, vertices, faces)
        body = None if kept is None else _body(vertices, kept)
        if kept is None or body is None:
            break
        if not stands and not _is_background(vertices[body] @ frame.table[0] - frame.table[1]):
            break
        faces, planes, table = kept, (*planes, frame.table), None
        frame = propose_frame(vertices, faces)
    return WithoutBackground(faces, replace(frame, background=planes), table)


def cut_background(vertices: Array, faces: Integers, frame: Frame) -> WithoutBackground:
    """Cuts the background planes of a known frame."""
    left = faces
    for plane in frame.background:
        kept = _left_by(found_table(vertices, left, *plane), vertices, left)
        left = left if kept is None else kept
    return WithoutBackground(left, frame)


def _left_by(plane: Table, vertices: Array, faces: Integers) -> Integers | None:
    """The triangles that are not of this plane; None when it cannot be cut, or too little is left."""
    kept = faces[~plane.triangles]
    if plane.plane is None or len(kept) < MIN_TRIANGLES:
        return None
    kept = kept[large_pieces(vertices, kept)[0]]  # without what curled up at its edge
    return kept if len(kept) >= MIN_TRIANGLES else None


def _body(vertices: Array, faces: Integers) -> Integers | None:
    """(V,) vertices of the largest piece that is not flat."""
    _, labels = triangle_components(faces, len(vertices))
    piece = labels[faces[:, 0]]
    sizes = np.bincount(piece)
    for which in np.argsort(-sizes):
        if sizes[which] < FRAGMENT_SHARE * sizes.max():
            return None
        mine = np.unique(faces[piece == which])
        if not is_flat(vertices[mine]):
            return mine
    return None


def is_flat(points: Array, spread: float = FLAT) -> bool:
    """Whether (N, 3) m points of a piece lie in a plane, to a standard deviation of `spread` (m)."""
    across = np.linalg.eigvalsh(np.cov(points.T))
    return bool(np.sqrt(max(float(across[0]), 0.0)) <= spread)


def _is_background(heights: Array) -> bool:
    """Whether a body with its vertices so high (m) above a plane does not lie on it."""
    low, high = np.quantile(heights, REACHES)
    return bool(high > HIGH or low > AWAY)


def _all_is_low(heights: Array) -> bool:
    """Whether all that is left of a scan lies so (m) above a plane as a body that lies on it."""
    return bool(len(heights) and heights.max() <= HIGH and np.quantile(heights, REACHES[0]) <= AWAY)


def only_body(vertices: Array, faces: Integers) -> Booleans:
    """(F,) triangles of the largest piece that is not flat: in a room all others are furniture or another person."""
    body = _body(vertices, faces)
    if body is None:
        return np.ones(len(faces), np.bool_)
    is_hers = np.zeros(len(vertices), np.bool_)
    is_hers[body] = True
    return np.asarray(is_hers[faces[:, 0]])
