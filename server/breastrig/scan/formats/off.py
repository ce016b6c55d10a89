"""OFF in text (Geomview's, MeshLab's, CGAL's): points with colours (COFF) or normals (NOFF), polygons with colours.

The numbers of points and polygons stand at the beginning, so a file that was cut off is seen.
"""

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import OFF_START
from breastrig.scan.formats.polygons import fans, few_corners, ranges, split, whole_numbers
from breastrig.scan.limits import TOO_MANY_TRIANGLES, TRIANGLES, VERTICES
from breastrig.scan.piece import PARTLY_COLOURED, UNCOLOURED, Piece, Pieces, PointCloud, colour_bytes
from breastrig.scan.point_clouds.numbers_in_text import REMARK, numbers

UNUSUAL = "This OFF file is {}, which is not read here; export the scan as OFF in text, PLY, OBJ, STL or GLB."
COLOURS_LEFT = "Colours of this OFF file that are numbers of a table were left out."


def read_off(data: bytes) -> Pieces:
    """The file's mesh or points. Raises BadScan, TooLarge, or ValueError where it is damaged or cut off."""
    lines = [bare for line in data.replace(b"\r", b"\n").split(b"\n") if (bare := REMARK.sub(b"", line).strip())]
    head = OFF_START.match(lines[0])
    assert head is not None
    counts, at = lines[0][head.end() :].split(), 1
    if head["more"] or counts[:1] in ([b"BINARY"], [b"binary"]):
        raise BadScan(UNUSUAL.format("of more than three dimensions" if head["more"] else "binary"))
    if not counts:
        counts, at = lines[1].split(), 2
    points, polygons = int(counts[0]), int(counts[1])
    if points > VERTICES or polygons > TRIANGLES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    if min(points, polygons) < 0 or len(lines) < at + points + polygons:
        raise ValueError("too few rows")
    vertices, colours = _points(lines[at : at + points], bool(head["normals"]), bool(head["colours"]))
    faces, of_faces, notes = _faces(lines[at + points : at + points + polygons])
    if not len(faces):
        return Pieces((), has_points=True, cloud=PointCloud(vertices, None, colours), notes=notes)
    if not 0 <= faces.min() <= faces.max() < len(vertices):
        raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
    if colours is not None or of_faces is None:
        return Pieces((Piece(vertices, faces, colours),), notes=notes)
    which, faces, values = split(faces, np.repeat(of_faces[:, None].astype(np.float64), 3, axis=1))
    return Pieces((Piece(vertices[which], faces, values.astype(np.uint8)),), notes=notes)


def _points(rows: list[bytes], has_normals: bool, has_colours: bool) -> tuple[Array, NDArray[np.uint8] | None]:
    """(V, 3) places and (V, 3) colours, behind a normal where there is one."""
    found, widths = numbers(rows)
    if len(rows) and int(widths.min()) < 3:
        raise ValueError("a point with too few numbers")
    starts, at = np.cumsum(widths) - widths, 6 if has_normals else 3
    points = found[starts[:, None] + np.arange(3)] if len(rows) else np.zeros((0, 3))
    if not has_colours or not len(rows) or int(widths.min()) < at + 3:
        return points, None
    return points, colour_bytes(found[starts[:, None] + at + np.arange(3)])


def _faces(rows: list[bytes]) -> tuple[Integers, NDArray[np.uint8] | None, tuple[str, ...]]:
    """((F, 3) triangles, (F, 3) colours of them or None, notes)."""
    if not rows:
        return np.zeros((0, 3), np.int64), None, ()
    found, widths = numbers(rows)
    starts = np.cumsum(widths) - widths
    counts = whole_numbers(found[starts])
    more = widths - 1 - counts
    if (counts < 0).any() or (more < 0).any():
        raise ValueError("a polygon with too few numbers")
    if int(np.maximum(counts - 2, 0).sum()) > TRIANGLES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    order, polygons = fans(counts)
    faces = whole_numbers(found[ranges(starts + 1, counts)])[order]
    few = int((counts < 3).sum())
    notes: tuple[str, ...] = (few_corners(few),) if few else ()
    painted = more >= 3
    if (more[~painted] > 0).any():
        notes += (COLOURS_LEFT,)
    if not painted.any():
        return faces, None, notes
    colours = np.full((len(rows), 3), UNCOLOURED, np.uint8)
    behind = (starts + 1 + counts)[painted]
    colours[painted] = colour_bytes(found[behind[:, None] + np.arange(3)])
    return faces, colours[polygons], notes if painted.all() else (*notes, PARTLY_COLOURED)
