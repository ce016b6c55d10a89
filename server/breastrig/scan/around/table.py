"""The table under a lying patient, cut away before the fit.

scan/orient.py proposes a plane from a sample of the triangles; here it is laid through all of them, and what lies
within the scanner's noise of it and faces as it does is the table.  Skin that rests on the table leaves it steeply, so
close to the plane the direction decides; a flank may come down to the plane and stays.  Pieces that then nowhere rise
above the plane are fragments of the table, its edge, or the floor.  What is connected with the body, such as an arm
beside a narrow table, is never one of them.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import triangle_components
from breastrig.geometry.normals import face_crosses, vertex_normals
from breastrig.geometry.plane import Plane

FIRST_BAND = 0.02  # m, around the proposed plane: two of its bins
FACING = np.cos(np.radians(20.0))  # of what the plane is laid through, as in scan/orient.py
LIKE_TABLE = np.cos(np.radians(40.0))  # of what is cut; noise tilts small triangles, skin leaves the table steeper
ROUNDS = 5  # of laying the plane through what lies near it; it rests after two or three
LEAST_BAND, MOST_BAND = 0.006, 0.012  # m; simulated scans of tables lie within 4 mm of their plane
FLAT = 0.004  # m, standard deviation; 14 simulated scans of tables have 0.6 to 1.3 mm; three times as much is none
BEHIND_SHARE = 0.06  # of the area may lie behind the plane, as in scan/orient.py: a patch of skin has a body behind it


@dataclass(frozen=True, eq=False)
class Table:
    """The part of a scan that is a table."""

    triangles: Booleans  # (F,)
    plane: Plane | None  # its normal to the body; None where there is no table


def found_table(vertices: Array, faces: Integers, normal: Array, level: float) -> Table:
    """The table for the plane at height `level` (m) along a (3,) unit normal to the body.

    None when nothing flat is there, or more lies behind it than behind a table.
    """
    none = Table(np.zeros(len(faces), dtype=np.bool_), None)
    result = np.zeros(len(faces), dtype=np.bool_)
    crosses = face_crosses(vertices, faces)
    areas = np.linalg.norm(crosses, axis=1)
    laid = _laid(vertices[faces].mean(axis=1), crosses, areas, normal, level)
    if laid is None:
        return none
    normal, level, spread = laid
    band = float(np.clip(4.0 * spread, LEAST_BAND, MOST_BAND))
    heights = vertices @ normal - level
    corners = heights[faces]
    if areas[corners.max(axis=1) < -FIRST_BAND].sum() > BEHIND_SHARE * areas.sum():
        return none
    low = np.flatnonzero(corners.min(axis=1) < band)  # all triangles of the vertices below the band's upper side
    near, corners = faces[low], corners[low]
    facing = vertex_normals(vertices, near) @ normal  # of all triangles around a vertex: single ones are noisy
    flat: Booleans = (np.abs(corners) < band).all(axis=1) & (facing[near].mean(axis=1) > LIKE_TABLE)
    result[low] = flat | _low_pieces(near, flat, heights, band)
    return Table(result, Plane(normal, level))


def _laid(
    centres: Array, crosses: Array, areas: Array, normal: Array, level: float
) -> tuple[Array, float, float] | None:
    """(normal, level, standard deviation in m) of the plane through what lies near it and faces as it does."""
    close = np.abs(centres @ normal - level) < 2.0 * FIRST_BAND  # more is never near
    centres, crosses, areas = centres[close], crosses[close], areas[close]
    band = FIRST_BAND
    for _ in range(ROUNDS):
        heights = centres @ normal - level
        near = (np.abs(heights) < band) & (crosses @ normal > FACING * areas)
        total = areas[near].sum()
        if total == 0.0:
            return None
        weights = areas[near, None] / total
        middle = (weights * centres[near]).sum(axis=0)
        offsets = centres[near] - middle
        squares, axes = np.linalg.eigh((offsets * weights).T @ offsets)
        normal = axes[:, 0] if axes[:, 0] @ normal > 0.0 else -axes[:, 0]
        level, spread = float(middle @ normal), float(np.sqrt(max(squares[0], 0.0)))
        band = float(np.clip(4.0 * spread, LEAST_BAND, FIRST_BAND))
    return (normal, level, spread) if spread < FLAT else None


def _low_pieces(faces: Integers, flat: Booleans, heights: Array, band: float) -> Booleans:
    """(F,) triangles that are not flat but connected with nothing that rises above the band."""
    rest = faces[~flat]
    count, piece = triangle_components(rest, len(heights))
    rises = np.zeros(count, dtype=np.bool_)
    rises[piece[heights >= band]] = True
    result = np.zeros(len(faces), dtype=np.bool_)
    result[~flat] = ~rises[piece[rest[:, 0]]]
    return result
