"""STL: binary or text, whatever its header says of the number of triangles; colours of facets where it has them."""

import re

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.file_type import BINARY_STL_HEADER, BINARY_STL_TRIANGLE, is_text_stl
from breastrig.scan.formats.polygons import split
from breastrig.scan.limits import STL_SOLIDS, TOO_MANY_TRIANGLES, TRIANGLES
from breastrig.scan.piece import Piece, Pieces
from breastrig.scan.point_clouds.numbers_in_text import first_columns

ROW = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
END = re.compile(rb"\bend\s+(facet|loop|solid)\b")
WRONG_COUNT = (
    "The header of this STL file announces another number of triangles; all {count:,} that it holds were read."
)
CUT_OFF = "This STL file is cut off or damaged: its length does not fit its triangles; export it again."


def read_stl(data: bytes) -> Pieces:
    """The file's mesh. Raises BadScan, TooLarge, or ValueError where it is damaged or cut off."""
    if is_text_stl(data):
        vertices, faces = _joined(_text(data).reshape(-1, 3, 3))
        return Pieces((Piece(vertices, faces),))
    rows, notes = _binary(data)
    with np.errstate(invalid="ignore"):  # what is no number stays none
        vertices, faces = _joined(rows["corners"].astype(np.float64))
    colours = _colours(data, rows["attribute"])
    if colours is None:
        return Pieces((Piece(vertices, faces),), notes=notes)
    which, faces, values = split(faces, np.repeat(colours[:, None], 3, axis=1))
    return Pieces((Piece(vertices[which], faces, values.astype(np.uint8)),), notes=notes)


def _binary(data: bytes) -> tuple[NDArray[np.void], tuple[str, ...]]:
    """The rows of triangles.  Fewer than announced are a file that was cut off, unless the number is none at all."""
    announced = int.from_bytes(data[BINARY_STL_HEADER - 4 : BINARY_STL_HEADER], "little")
    held, rest = divmod(len(data) - BINARY_STL_HEADER, BINARY_STL_TRIANGLE)
    is_no_count = announced == 0 or announced > TRIANGLES  # written before the triangles were counted
    if held < announced and not (is_no_count and rest == 0):
        raise TooLarge(TOO_MANY_TRIANGLES) if held > TRIANGLES else BadScan(CUT_OFF)
    count = held if announced != held and rest == 0 and _go_on(data, announced, held) else announced
    if count > TRIANGLES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    notes = () if count == announced else (WRONG_COUNT.format(count=count),)
    return np.frombuffer(data, ROW, count, BINARY_STL_HEADER), notes


@np.errstate(invalid="ignore", over="ignore")  # what is no number goes on nowhere
def _go_on(data: bytes, announced: int, held: int) -> bool:
    """Whether what follows the triangles that are announced are triangles of the same body, and nothing else."""
    corners = np.frombuffer(data, ROW, min(held, TRIANGLES), BINARY_STL_HEADER)["corners"].reshape(-1, 3)
    first, others = corners[: 3 * announced], corners[3 * announced :]
    is_filled = len(others) > 0 and not np.ptp(others.reshape(-1, 3, 3), axis=1).any()
    if is_filled or not np.isfinite(others).all():
        return False
    if not len(first):
        return True
    low, high = first.min(axis=0), first.max(axis=0)
    margin = 4.0 * np.max(high - low)
    return bool(((others >= low - margin) & (others <= high + margin)).all())


def _text(data: bytes) -> Array:
    """(3 F, 3) corners."""
    text = END.sub(rb"end\1", data.replace(b"\r", b"\n").lower())
    rows = [line.split(None, 1)[1] for line in text.split(b"\n") if line.split(None, 1)[:1] == [b"vertex"]]
    if len(rows) > 3 * TRIANGLES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    if text.count(b"endsolid") > STL_SOLIDS:
        raise TooLarge(f"This STL file has more than the {STL_SOLIDS} parts allowed; join them.")
    if text.rfind(b"endsolid") <= text.rfind(b"vertex") or len(rows) != 3 * text.count(b"endfacet"):
        raise ValueError("cut off")
    return first_columns(rows, 3)


def _colours(data: bytes, attributes: NDArray[np.uint16]) -> NDArray[np.uint8] | None:
    """(F, 3) of five bits each, as Magics (COLOR= in the title) or VisCAM writes them; None where there are none."""
    title = data[: BINARY_STL_HEADER - 4]
    at = title.find(b"COLOR=")
    own = (attributes & 0x8000 == 0) if at >= 0 else (attributes & 0x8000 != 0)
    if not own.any() or (at < 0 and not own.all()):
        return None
    shifts = (0, 5, 10) if at >= 0 else (10, 5, 0)
    colours = np.stack([(attributes >> shift & 31) * 255.0 / 31.0 for shift in shifts], axis=1)
    if at >= 0:
        colours[~own] = list(title[at + 6 : at + 9].ljust(3, b"\0"))
    return np.asarray(np.round(colours).astype(np.uint8))


def _joined(triangles: Array) -> tuple[Array, Integers]:
    """(V, 3) vertices and (F, 3) faces of (F, 3, 3) corners.

    An STL repeats each corner for each triangle; equal ones become one again (exactly equal, float32).
    """
    vertices = triangles.reshape(-1, 3)
    with np.errstate(over="ignore"):  # text may hold larger numbers, which are left out later
        single = vertices.astype(np.float32) + np.float32(0.0)
    exact = single.view(np.uint32).astype(np.uint64)
    first_two = (exact[:, 0] << np.uint64(32)) | exact[:, 1]
    order = np.lexsort((exact[:, 2], first_two))
    starts = np.ones(len(order), np.bool_)
    starts[1:] = (first_two[order][1:] != first_two[order][:-1]) | (exact[order, 2][1:] != exact[order, 2][:-1])
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    return vertices[order[starts]], group.reshape(-1, 3)
