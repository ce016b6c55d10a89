"""Clouds of points as plain rows of numbers (.xyz, .asc, .pts, .txt, .csv): x y z, then colours, a normal or others.

A row of words may name the columns.  Else they are distinguished by their numbers: the first that counts the rows is an
index, three whole ones up to 255 or shares up to 1 are a colour, three that make a unit vector are a normal, and what
is left over (an intensity) is passed by.
"""

import re

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import POINTS, TOO_MANY_POINTS
from breastrig.scan.piece import PointCloud, colour_bytes
from breastrig.scan.point_clouds.numbers_in_text import NO_NUMBER, numbers, with_points

ROWS = 20  # lines in which a file shows that it is nothing but numbers
HEAD = 10  # lines of words before them, at most
COLUMNS = 16  # at most: index, place, normal, colour, and what a scanner adds
UNIT = 0.02  # that the length of a normal may differ from one: such files are rounded
REMARKS = (b"#", b"//", b"%", b"!")
NUMBER = re.compile(
    rb"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?$|[-+]?(?:nan|inf)$|" + NO_NUMBER.pattern, re.IGNORECASE
)
NAMES = {
    **{name: name for name in ("x", "y", "z", "nx", "ny", "nz")},
    **{"normalx": "nx", "normaly": "ny", "normalz": "nz", "r": "r", "g": "g", "b": "b"},
    **{"red": "r", "green": "g", "blue": "b", "rot": "r", "gruen": "g", "grün": "g", "blau": "b"},
}
UNITS = re.compile(r"[\[(].*?[\])]|[^a-zü]")  # in a column's name
DAMAGED = "The rows of this point file are not all alike, as in one that was cut off; export it again."


def is_point_table(start: bytes) -> bool:
    """Whether a file that starts so holds rows of three or more numbers, after lines of words or their count."""
    try:
        _, rows = _rows(start.splitlines()[:-1] if len(start.splitlines()) > ROWS else start.splitlines())
    except ValueError:
        return False
    widths = {len(row.split()) for row in rows[:ROWS]}
    return len(rows) >= 2 and len(widths) == 1 and 3 <= widths.pop() <= COLUMNS


def table_points(data: bytes) -> PointCloud:
    """The points of such a file.  BadScan or TooLarge with a sentence."""
    try:
        names, rows = _rows(data.splitlines())
        if len(rows) > POINTS:
            raise TooLarge(TOO_MANY_POINTS)
        found, widths = numbers(rows)
        table = found.reshape(len(rows), -1)
        if (widths != table.shape[1]).any():
            raise ValueError("rows that differ")
    except ValueError as error:
        raise BadScan(DAMAGED) from error
    if names is not None and len(names) == table.shape[1] and {"x", "y", "z"} <= set(names):
        return _named(dict(zip(reversed(names), table.T[::-1], strict=True)))
    return _by_numbers(table)


def _rows(lines: list[bytes]) -> tuple[list[str] | None, list[bytes]]:
    """(the columns' names, rows of numbers with spaces and points); ValueError where there are none."""
    filled = [line.strip() for line in lines if line.strip()]
    separator = next((mark for mark in (b";", b"\t") if any(mark in line for line in filled[-ROWS:])), None)
    head: list[bytes] = []
    at = 0
    for line in filled:
        words = _words(line, separator)
        if len(words) >= 3 and all(NUMBER.match(word) for word in words):
            break
        is_count = len(words) == 1 and words[0].isdigit()
        if not line.startswith(REMARKS) and not is_count:
            head.append(line)
        elif not is_count:
            head.append(line.lstrip(b"#/%! "))
        at += 1
        if len(head) > HEAD and not line.startswith(REMARKS):
            raise ValueError("words, and no numbers")
    else:
        raise ValueError("no rows of numbers")
    rows = [line for line in filled[at:] if not line.startswith(REMARKS)]
    if separator is not None:
        decimal = any(b"," in row for row in rows) and not any(b"." in row for row in rows)
        rows = [row.replace(b",", b"." if decimal else b" ").replace(separator, b" ") for row in rows]
    rows = [row.replace(b'"', b"") for row in with_points(rows)]
    names = [_words(line, separator or (b"," if b"," in line else None)) for line in head[-1:]]
    return [_name(word) for word in names[0]] if names else None, rows


def _words(line: bytes, separator: bytes | None) -> list[bytes]:
    """The cells of one row; without a separator, split at spaces or at commas."""
    if separator is not None:
        return [word.strip().strip(b'"') for word in line.strip(separator + b" ").split(separator)]
    words = line.replace(b", ", b" ").split()
    if len(words) < 3 and b"," in line:
        return [word.strip().strip(b'"') for word in line.strip(b", ").split(b",")]
    return [word.strip(b",") for word in words]


def _name(word: bytes) -> str:
    text = UNITS.sub("", word.decode("utf-8", "replace").casefold())
    return NAMES.get(text, NAMES.get(text.removeprefix("pos").removeprefix("coord"), text))


def _named(columns: dict[str, Array]) -> PointCloud:
    def three(names: str) -> Array | None:
        wanted = names.split()
        return np.stack([columns[name] for name in wanted], axis=1) if set(wanted) <= set(columns) else None

    points, colours = three("x y z"), three("r g b")
    assert points is not None
    return PointCloud(points, three("nx ny nz"), None if colours is None else colour_bytes(colours), None)


def _by_numbers(table: Array) -> PointCloud:
    counts = table[:, 0]
    if table.shape[1] > 3 and len(table) > 1 and (np.diff(counts) == 1.0).all():
        table = table[:, 1:]
    if table.shape[1] in (7, 10) and (table[:, -1] == table[0, -1]).all():
        table = table[:, :-1]  # an opacity
    normals: Array | None = None
    colours: NDArray[np.uint8] | None = None
    for first in range(table.shape[1] - 3, 2, -1):
        three = table[:, first : first + 3]
        if normals is None and _are_normals(three):
            normals = three
        elif colours is None and _are_colours(three):
            colours = colour_bytes(three)
    return PointCloud(table[:, :3], normals, colours, None)


def _are_colours(three: Array) -> bool:
    """Whether the values are whole numbers up to 255, or shares of one."""
    low, high = float(three.min()), float(three.max())
    is_whole = bool((three == np.round(three)).all())
    return low >= 0.0 and (1.0 < high <= 255.0 if is_whole else high <= 1.0)


def _are_normals(three: Array) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(np.linalg.norm(three, axis=1) - 1.0) < UNIT).mean() > 0.99)
