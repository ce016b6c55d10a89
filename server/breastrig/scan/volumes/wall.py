"""The chest wall that a volume names (pectoral muscle, chest wall), as it is seen from the breast."""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.geometry.normals import face_normals
from breastrig.scan.clean import compact
from breastrig.scan.piece import TakenSegment
from breastrig.scan.volumes.body import front_of, skin
from breastrig.scan.volumes.segments import LOOKED_AT, names_wall
from breastrig.scan.volumes.volume import Volume

BEHIND = 4.0  # mm behind what of it is first seen from the front, which still is its surface
FACING = 0.2  # cosine between its normals and the front, at least
MARGIN = 3  # voxels of nothing around it
STEP = 8.0  # mm between its vertices, in columns towards the front
COLUMNS = 100  # at most, to each side
SEEN = (
    "The chest wall is the front of the muscle or wall that this file names; lesions near it are transferred with the "
    "breastbone."
)


def wall_of(volume: Volume, taken: tuple[TakenSegment, ...], affine: Array) -> tuple[Array, Integers] | None:
    """(V, 3) mm, LPS, and (F, 3) triangles that face the front; None where no segment is named so.

    `affine` (4, 4) leads from the volume's voxels to mm.
    """
    tissue = {each.number for each in taken if each.taken_as == "tissue"}
    named = [each for each in volume.segments if each.number in tissue and names_wall(each.label)]
    if not named or sum(float(np.prod([side.stop - side.start for side in each.box])) for each in named) > LOOKED_AT:
        return None
    low = np.min([[side.start for side in each.box] for each in named], axis=0) - MARGIN
    high = np.max([[side.stop for side in each.box] for each in named], axis=0) + MARGIN
    there = np.zeros(high - low, np.bool_, order="F")
    for each in named:
        box = tuple(slice(side.start - start, side.stop - start) for side, start in zip(each.box, low, strict=True))
        there[box] |= each.inside()
    moved = affine.copy()
    moved[:3, 3] += affine[:3, :3] @ low
    try:
        vertices, faces = skin(there, moved)
    except BadInput:  # too thin for a surface, or noise
        return None
    seen = _faces_the_front(vertices, faces, there, moved)
    vertices, faces = _thinned(vertices, faces[seen])
    return (vertices, faces) if len(faces) else None


def _thinned(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The sheet with one vertex in each column of STEP mm from back to front, the mean of those that were there."""
    used, faces = np.unique(faces, return_inverse=True)
    places = vertices[used][:, [0, 2]]
    columns = np.floor(places / max(STEP, np.ptp(places, axis=0).max(initial=0.0) / COLUMNS))
    _, column = np.unique(columns, axis=0, return_inverse=True)
    sums = np.stack([np.bincount(column.ravel(), each) for each in vertices[used].T], axis=1)
    corners = column.ravel()[faces.reshape(-1, 3)]
    corners = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    return compact(sums / np.maximum(np.bincount(column.ravel()), 1)[:, None], corners[np.sort(first)])


def _faces_the_front(vertices: Array, faces: Integers, there: Booleans, affine: Array) -> Booleans:
    """(F,) whether a triangle is the first that a look from the front meets."""
    axis, end = front_of(affine)
    step = float(np.linalg.norm(affine[:3, axis]))
    columns = np.moveaxis(there, axis, 0)
    columns = columns if end == 0 else columns[::-1]
    first = np.where(columns.any(axis=0), columns.argmax(axis=0), len(columns))
    middles = np.linalg.inv(affine)[:3] @ np.column_stack([vertices[faces].mean(axis=1), np.ones(len(faces))]).T
    along = middles[axis] if end == 0 else len(columns) - 1 - middles[axis]
    across = np.rint(np.delete(middles, axis, axis=0)).astype(np.int64)
    across = np.clip(across, 0, np.array(first.shape)[:, None] - 1)
    forwards = affine[:3, axis] / step * (-1.0 if end == 0 else 1.0)
    facing = face_normals(vertices, faces) @ forwards > FACING
    return np.asarray(facing & (along < first[across[0], across[1]] + BEHIND / step))
